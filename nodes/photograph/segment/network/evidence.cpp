#include "nodes/photograph/segment/network/evidence.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/rank.h"

namespace terrazzo::segment {
namespace {

float log_ratio(double a, double b) { return std::log((a + 0.03) / (b + 0.03)); }

cv::Mat shrunk(const cv::Mat& mask, const cv::Mat& element, int times) {
  cv::Mat out;  // what lies beyond the section does not shrink it
  cv::erode(mask, out, element, cv::Point(-1, -1), times, cv::BORDER_CONSTANT, 255);
  return out;
}

double mean_of(const cv::Mat& map, const cv::Mat& mask, double otherwise) {
  return cv::countNonZero(mask) > 0 ? cv::mean(map, mask)[0] : otherwise;
}

double quantile_of(const cv::Mat& map, const cv::Mat& mask, double q, double otherwise) {
  std::vector<float> values;
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x)
      if (mask.at<std::uint8_t>(y, x)) values.push_back(map.at<float>(y, x));
  if (values.empty()) return otherwise;
  return at_rank(values, static_cast<std::size_t>(q * (values.size() - 1)));
}

}  // namespace

Evidence evidence_of(const Cutout& r, const ScaleView& view, const cv::Mat& near_border) {
  static const cv::Mat square = cv::Mat::ones(3, 3, CV_8U),
                       cross = cv::getStructuringElement(cv::MORPH_CROSS, cv::Size(3, 3));
  const NetworkMaps& m = view.maps();
  const cv::Mat inside = view.map(m.inside)(r.box), border = view.map(m.border)(r.box),
                distance = view.map(m.distance)(r.box), other = view.map(m.not_material)(r.box);
  const double area = cv::countNonZero(r.mask);
  const cv::Mat edge = r.mask & (shrunk(r.mask, cross, 1) == 0);
  const cv::Mat within = shrunk(r.mask, square, 2);
  cv::Mat near, around;
  cv::dilate(r.mask, near, cross);
  cv::dilate(r.mask, around, square, cv::Point(-1, -1), 3);
  around &= near == 0;

  const double of_inside = cv::mean(inside, r.mask)[0];
  const double within_border = mean_of(border, within, 0.5);

  // The distance to the outline, where the section's edge is none.
  cv::Mat depth;
  cv::distanceTransform(r.mask, depth, cv::DIST_L2, 3);
  double deepest = 0, summit = 0;
  cv::minMaxLoc(depth, nullptr, &deepest, nullptr, nullptr, r.mask);
  cv::minMaxLoc(distance, nullptr, &summit, nullptr, nullptr, r.mask);
  deepest = std::min(deepest, std::sqrt(area));  // the region fills the section
  depth = cv::min(depth, deepest);
  const cv::Mat misfit = cv::abs(distance / std::max(summit, 0.05) - depth / deepest);

  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(r.mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto& outline = *std::max_element(outlines.begin(), outlines.end(),
                                          [](const auto& a, const auto& b) { return a.size() < b.size(); });
  std::vector<cv::Point> hull;
  cv::convexHull(outline, hull);
  // Contours run through the centers of pixels.
  const double hull_area = cv::contourArea(hull) + 0.5 * outline.size() + 1,
               length = cv::arcLength(outline, true) + 1;
  const cv::Moments mo = cv::moments(r.mask, true);
  const double half = (mo.mu20 + mo.mu02) / 2, spread = std::hypot((mo.mu20 - mo.mu02) / 2, mo.mu11),
               pixel = area / 12;

  const auto touches = [&](const cv::Mat& line, bool at_edge) {
    return at_edge && cv::countNonZero(line) > 0;
  };
  const bool cut = touches(r.mask.row(0), r.box.y == 0) || touches(r.mask.col(0), r.box.x == 0) ||
                   touches(r.mask.row(r.mask.rows - 1), r.box.br().y == m.height) ||
                   touches(r.mask.col(r.mask.cols - 1), r.box.br().x == m.width);
  const cv::Mat own_border = view.near_border()(r.box);
  return {static_cast<float>(std::log(area)),
          static_cast<float>(std::log(view.scale())),
          log_ratio(of_inside, mean_of(inside, around, of_inside)),
          log_ratio(mean_of(own_border, edge, 0.5), within_border),
          log_ratio(mean_of(near_border(r.box), edge, 0.5), within_border),
          static_cast<float>(quantile_of(own_border, edge, 0.2, 0.5)),
          static_cast<float>(quantile_of(border, within, 0.9, 0.5)),
          static_cast<float>(cv::mean(misfit, r.mask)[0]),
          static_cast<float>(12.566 * area / (length * length)),
          static_cast<float>(area / hull_area),
          static_cast<float>(std::sqrt(std::max(0.0, half - spread + pixel) / (half + spread + pixel))),
          static_cast<float>(deepest / std::sqrt(area)),
          cut ? 1.0f : 0.0f,
          static_cast<float>(cv::mean(other, r.mask)[0])};
}

}  // namespace terrazzo::segment
