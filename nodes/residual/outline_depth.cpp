#include "nodes/residual/outline_depth.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace terrazzo::residual {

std::vector<float> outline_depth(const std::int32_t* ids, int width, int height, bool wrap) {
  constexpr int kMargin = 32;  // of the repeated picture, where edges join
  const int margin = wrap ? kMargin : 0, w = width + 2 * margin, h = height + 2 * margin;
  const auto id = [&](int x, int y) {
    x = (x - margin + kMargin * width) % width, y = (y - margin + kMargin * height) % height;
    return ids[static_cast<std::size_t>(y) * width + x];
  };
  cv::Mat inside(h, w, CV_8U, cv::Scalar(255)), distance;
  bool any = false;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const auto differ = [&](int u, int v) {
        if (u >= w || v >= h || id(x, y) == id(u, v)) return;
        inside.at<std::uint8_t>(y, x) = inside.at<std::uint8_t>(v, u) = 0;
        any = true;
      };
      differ(x + 1, y), differ(x, y + 1);
    }
  const std::size_t pixels = static_cast<std::size_t>(width) * height;
  if (!any) return std::vector<float>(pixels, static_cast<float>(std::hypot(width, height)));
  cv::distanceTransform(inside, distance, cv::DIST_L2, cv::DIST_MASK_5);
  std::vector<float> out(pixels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      out[static_cast<std::size_t>(y) * width + x] = distance.at<float>(y + margin, x + margin) + 0.5f;
  return out;
}

}  // namespace terrazzo::residual
