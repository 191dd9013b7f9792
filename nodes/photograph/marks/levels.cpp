#include "nodes/photograph/marks/levels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "nodes/common/texture/color.h"

namespace terrazzo::segment {

cv::Mat levels_of(const Image& image, int section) {
  cv::Mat out(image.height, image.width, CV_8UC3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3f c = linear_to_srgb(image.at(x, y, section).cwiseMax(0.0f).cwiseMin(1.0f));
      for (int k = 0; k < 3; ++k) out.at<cv::Vec3b>(y, x)[k] = std::lround(255 * c[k]);
    }
  return out;
}

cv::Mat distance_from(const cv::Mat& levels, const cv::Vec3b& color) {
  const auto luma = [](const cv::Vec3b& c) { return 299 * c[0] + 587 * c[1] + 114 * c[2]; };
  const int own = luma(color);
  cv::Mat out(levels.size(), CV_8U);
  for (int y = 0; y < levels.rows; ++y)
    for (int x = 0; x < levels.cols; ++x) {
      const auto& c = levels.at<cv::Vec3b>(y, x);
      int most = 0;
      for (int k = 0; k < 3; ++k) most = std::max(most, std::abs(c[k] - color[k]));
      out.at<std::uint8_t>(y, x) = std::max((std::abs(luma(c) - own) + 500) / 1000, most / 4);
    }
  return out;
}

cv::Vec3b commonest(const cv::Mat& levels) {
  std::vector<std::uint32_t> all;
  all.reserve(levels.total());
  for (int y = 0; y < levels.rows; ++y)
    for (int x = 0; x < levels.cols; ++x) {
      const auto& c = levels.at<cv::Vec3b>(y, x);
      all.push_back(c[0] | c[1] << 8 | c[2] << 16);
    }
  std::sort(all.begin(), all.end());
  std::uint32_t best = 0;
  std::ptrdiff_t most = 0;
  for (auto i = all.begin(); i != all.end();) {
    const auto end = std::upper_bound(i, all.end(), *i);
    if (end - i > most) {
      most = end - i;
      best = *i;
    }
    i = end;
  }
  return {static_cast<std::uint8_t>(best), static_cast<std::uint8_t>(best >> 8),
          static_cast<std::uint8_t>(best >> 16)};
}

}  // namespace terrazzo::segment
