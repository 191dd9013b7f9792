#include "nodes/solids/synthesis/exemplar/guide.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"

namespace terrazzo::solids {
namespace {

double threshold_of(const std::vector<SolidExemplar>& working) {
  std::vector<float> values;
  for (const auto& e : working)
    for (std::size_t i = 0; i < e.pixels.size(); ++i)
      if (e.usable.empty() || e.usable[i]) values.push_back(e.pixels[i][0]);
  if (values.empty()) return 0;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  cv::Mat bytes(1, count_of(values), CV_8U);
  const float from = *low, span = std::max(1e-6f, *high - *low);
  for (int i = 0; i < bytes.cols; ++i)
    bytes.at<std::uint8_t>(i) = std::lround(255 * (values[i] - from) / span);
  cv::Mat unused;
  return from + span * (cv::threshold(bytes, unused, 0, 1, cv::THRESH_BINARY | cv::THRESH_OTSU) + 0.5) / 255;
}

}  // namespace

void guide_by_phases(std::vector<SolidExemplar>& working, double weight, int reach) {
  const double level = threshold_of(working);
  double sum = 0, square = 0, count = 0;
  for (auto& e : working) {
    cv::Mat phase[2], distance[2];
    for (int k = 0; k < 2; ++k) phase[k].create(e.height, e.width, CV_8U);
    for (std::size_t i = 0; i < e.pixels.size(); ++i)
      for (int k = 0; k < 2; ++k) phase[k].data[i] = (e.pixels[i][0] > level) == (k == 0);
    for (int k = 0; k < 2; ++k)
      cv::distanceTransform(phase[k], distance[k], cv::DIST_L2, cv::DIST_MASK_PRECISE);
    e.guide.resize(e.pixels.size());
    for (std::size_t i = 0; i < e.guide.size(); ++i) {
      const int at = i;
      const int x = at % e.width, y = at / e.width;
      // The border is half a pixel from the pixel's center.
      const float d =
          phase[0].data[i] ? distance[0].at<float>(y, x) - 0.5f : 0.5f - distance[1].at<float>(y, x);
      e.guide[i] = std::clamp<float>(d, -reach, reach);
      sum += e.guide[i];
      square += static_cast<double>(e.guide[i]) * e.guide[i];
      ++count;
    }
  }
  const double mean = sum / count, deviation = std::sqrt(std::max(0.0, square / count - mean * mean));
  for (auto& e : working)
    for (float& g : e.guide) g = deviation > 0 ? static_cast<float>(weight * (g - mean) / deviation) : 0;
}

}  // namespace terrazzo::solids
