#include "nodes/detail/detail_solid/shadows.h"

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace terrazzo::detail_solid {

cv::Mat outside_with_shadows(const cv::Mat& outside, const cv::Mat& dark) {
  cv::Mat parts;
  std::vector<std::uint8_t> reaches(cv::connectedComponents(outside | dark, parts, 8, CV_32S), 0);
  for (int y = 0; y < parts.rows; ++y)
    for (int x = 0; x < parts.cols; ++x)
      if (outside.at<std::uint8_t>(y, x)) reaches[parts.at<int>(y, x)] = 255;
  cv::Mat out(parts.size(), CV_8U);
  for (int y = 0; y < parts.rows; ++y)
    for (int x = 0; x < parts.cols; ++x) out.at<std::uint8_t>(y, x) = reaches[parts.at<int>(y, x)];
  return out;
}

}  // namespace terrazzo::detail_solid
