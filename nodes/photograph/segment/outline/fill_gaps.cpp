#include "nodes/photograph/segment/outline/fill_gaps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

constexpr double kMissed = 0.35;  // distance from all particles, in mean diameters
constexpr double kBlur = 1;       // standard deviation in pixels, so that noise is no edge

cv::Mat encoded(const Image& image, int section) {
  cv::Mat out(image.height, image.width, CV_8UC3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3f c = linear_to_srgb(image.pixels[image.index(x, y, section)].cwiseMax(0.0f).cwiseMin(1.0f));
      auto& to = out.at<cv::Vec3b>(y, x);
      for (int k = 0; k < 3; ++k) to[k] = std::lround(255 * c[k]);
    }
  cv::GaussianBlur(out, out, {}, kBlur);
  return out;
}

}  // namespace

std::int32_t fill_gaps(std::vector<std::int32_t>& labels, const Image& image, int section) {
  const cv::Size size(image.width, image.height);
  std::int32_t count = *std::max_element(labels.begin(), labels.end());
  const double covered = std::count_if(labels.begin(), labels.end(), [](auto l) { return l > 0; });
  if (count == 0) {
    std::fill(labels.begin(), labels.end(), 1);
    return 1;
  }
  const double diameter = std::sqrt(4 / std::numbers::pi * covered / count);
  cv::Mat markers(size, CV_32S, labels.data());
  cv::Mat distance, missed, parts;
  cv::distanceTransform(markers == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  missed = distance > kMissed * diameter;
  const int found = cv::connectedComponents(missed, parts, 8, CV_32S) - 1;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (const int part = parts.ptr<int>()[i]; part > 0) labels[i] = count + part;
  count += found;
  if (count > 1)
    cv::watershed(encoded(image, section), markers);  // writes into `labels`; −1 on lines between particles
  else
    std::fill(labels.begin(), labels.end(), 1);
  // Pixels of lines join the first neighbor that is a particle.
  bool left = true;
  while (left) {
    left = false;
    bool any = false;
    const std::vector<std::int32_t> before = labels;
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        const auto at = pixel_at(x, y, size.width);
        if (before[at] > 0) continue;
        left = true;
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
          if (x + dx < 0 || x + dx >= size.width || y + dy < 0 || y + dy >= size.height) continue;
          if (const auto l = before[at + static_cast<std::ptrdiff_t>(dy) * size.width + dx]; l > 0) {
            labels[at] = l;
            any = true;
            break;
          }
        }
      }
    if (!any) break;
  }
  return count;
}

}  // namespace terrazzo::segment
