#include "nodes/bodies/view/softness.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"

namespace terrazzo::view {
namespace {

constexpr double kAntialiased = 0.3;  // pixels by which outlines are soft already
constexpr float kBlurred = 2;         // deviations of the blur from an outline

// The distance of each pixel from the nearest one on an outline.
cv::Mat distance_from_outlines(const std::vector<std::int32_t>& stone, int width, int height) {
  cv::Mat inside(height, width, CV_8U, cv::Scalar(255));
  const auto at = [&](int x, int y) { return stone[pixel_at(x, y, width)]; };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width && at(x, y) != at(x + 1, y))
        inside.at<std::uint8_t>(y, x) = inside.at<std::uint8_t>(y, x + 1) = 0;
      if (y + 1 < height && at(x, y) != at(x, y + 1))
        inside.at<std::uint8_t>(y, x) = inside.at<std::uint8_t>(y + 1, x) = 0;
    }
  cv::Mat distance;
  cv::distanceTransform(inside, distance, cv::DIST_L2, cv::DIST_MASK_5);
  return distance;
}

}  // namespace

void soften_outlines(Vec3f* picture, const std::vector<std::int32_t>& stone, int width, int height,
                     double pixels) {
  if (!(pixels > kAntialiased)) return;
  const double sigma = std::sqrt(pixels * pixels - kAntialiased * kAntialiased);
  const cv::Mat sharp(height, width, CV_32FC3, picture);
  cv::Mat soft;
  cv::GaussianBlur(sharp, soft, {0, 0}, sigma, 0, cv::BORDER_REFLECT);
  const cv::Mat distance = distance_from_outlines(stone, width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float share =
          std::clamp(1.5F - distance.at<float>(y, x) / (kBlurred * static_cast<float>(sigma)), 0.0F, 1.0F);
      if (share <= 0) continue;
      const auto& blurred = soft.at<cv::Vec3f>(y, x);
      Vec3f& pixel = picture[pixel_at(x, y, width)];
      pixel += share * (Vec3f(blurred[0], blurred[1], blurred[2]) - pixel);
    }
}

}  // namespace terrazzo::view
