#include "nodes/common/stereology/silhouette.h"

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "nodes/common/stereology/outline_features.h"

namespace terrazzo {
namespace {

constexpr int kPoints = 96;           // along the outline
constexpr std::size_t kFewest = 20;   // points that determine an ellipse
constexpr double kOnHull = 0.02;      // largest distance from the hull, relative to the outline's size
constexpr double kLongest = 3.5;      // axis ratio of an ellipse that may be a stone's silhouette
constexpr double kMostHidden = 0.75;  // share of a silhouette that may be hidden

// The points of the outline that are assumed not to be covered by other stones: those on its convex hull.
std::vector<cv::Point2f> own_points(const std::vector<cv::Point2f>& outline,
                                    const std::vector<cv::Point2f>& hull, double size) {
  std::vector<cv::Point2f> own;
  for (const cv::Point2f& p : outline)
    if (cv::pointPolygonTest(hull, p, true) < kOnHull * size) own.push_back(p);
  return own;
}

}  // namespace

double whole_silhouette(const Loop& visible) {
  if (visible.size() < 3) return 0;
  // Coordinates relative to the first point, which is enough for single precision.
  std::vector<cv::Point2f> outline, hull;
  for (const Vec2& p : resampled_loop(visible, kPoints)) {
    const Vec2 q = p - visible[0];
    outline.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()));
  }
  cv::convexHull(outline, hull);
  const double area = cv::contourArea(outline), least = cv::contourArea(hull);
  const auto own = own_points(outline, hull, std::sqrt(4 * area / std::numbers::pi));
  if (own.size() < kFewest) return least;
  const cv::RotatedRect e = cv::fitEllipseDirect(own);
  const double a = e.size.width, b = e.size.height, whole = std::numbers::pi / 4 * a * b;
  const bool possible =
      std::isfinite(whole) && (1 - kMostHidden) * whole < area && std::max(a, b) < kLongest * std::min(a, b);
  return possible ? std::max(least, whole) : least;
}

}  // namespace terrazzo
