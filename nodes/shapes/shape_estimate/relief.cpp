#include "nodes/shapes/shape_estimate/relief.h"

#include <cmath>
#include <numbers>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/outline_features.h"

namespace terrazzo::shape_estimate {
namespace {

constexpr int kPoints = 128;

}  // namespace

double relief_of(const Outline& o) {
  const double aspect = outline_features(o.points)[OutlineFeature::Aspect];
  if (!(aspect > 0)) return 0;
  const double a = std::sqrt(o.area / (std::numbers::pi * aspect));
  const Vec2 axes(a, a * aspect);
  double sum = 0;
  double squares = 0;
  for (const Vec2& p : resampled_loop(o.points, kPoints)) {
    const double r = p.cwiseQuotient(axes).norm();
    sum += r;
    squares += r * r;
  }
  const double mean = sum / kPoints;
  return std::sqrt(std::max(0.0, squares / kPoints - mean * mean));
}

double usual_relief(const std::vector<Outline>& outlines) {
  constexpr double kQuartile = 0.25;
  std::vector<double> all;
  for (const Outline& o : outlines) all.push_back(relief_of(o));
  if (all.empty()) return 0;
  return at_rank(all, all.size() * kQuartile);
}

double usual_corners(const std::vector<Outline>& outlines) {
  constexpr double kFullTurn = 360;  // degrees
  std::vector<double> shares;
  for (const Outline& o : outlines) {
    double turn = 0;
    for (const double corner : o.corner) turn += std::max(0.0, corner);
    shares.push_back(turn / kFullTurn);
  }
  return shares.empty() ? 0 : median(std::move(shares));
}

}  // namespace terrazzo::shape_estimate
