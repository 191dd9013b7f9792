#include "nodes/common/stereology/outline_measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop_moments.h"

namespace terrazzo {
namespace {

// A convex polygon is narrowest across one of its sides. The farthest corner moves on with the side (rotating
// calipers, Toussaint 1983).
double smallest_width(const Loop& hull) {
  const std::size_t n = hull.size();
  double width = INFINITY;
  for (std::size_t i = 0, far = 1; i < n; ++i) {
    const Vec2 side = hull[(i + 1) % n] - hull[i];
    const auto height = [&](std::size_t k) { return cross(side, hull[k % n] - hull[i]); };
    while (height(far + 1) > height(far)) ++far;
    width = std::min(width, height(far) / side.norm());
  }
  return width;
}

double largest_distance(const Loop& hull) {
  double square = 0;
  for (std::size_t i = 0; i < hull.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) square = std::max(square, (hull[i] - hull[k]).squaredNorm());
  return std::sqrt(square);
}

}  // namespace

OutlineMeasures outline_measures(const Loop& loop) {
  OutlineMeasures out;
  if (loop.size() < 3) return out;
  const LoopMoments m = loop_moments(loop);
  if (!(m.area > 0)) return out;
  const Loop hull = hull_of(loop);
  out.perimeter = loop_perimeter(loop);
  out.major_axis = 4 * std::sqrt(m.longer);
  out.minor_axis = 4 * std::sqrt(m.shorter);
  const double degrees = m.angle * 180 / std::numbers::pi;
  out.orientation = degrees < 0 ? degrees + 180 : degrees;
  out.feret_max = largest_distance(hull);
  out.feret_min = smallest_width(hull);
  out.circularity = 4 * std::numbers::pi * m.area / (out.perimeter * out.perimeter);
  out.solidity = std::min(1.0, m.area / loop_area(hull));
  return out;
}

}  // namespace terrazzo
