#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/shape_estimate/method.h"
#include "nodes/shape_estimate/morph_frame.h"

namespace terrazzo::shape_estimate {

namespace {

using std::numbers::pi;

struct Halves {
  Arc upper, lower;  // from the poles to the widest point: (distance from the axis, height above that point)
};

// The right half of the profile, cut along the vertical line through the center of the cuts, between
// the line's outermost crossings.
Halves right_half(const Outline& o) {
  const auto arcs = cut(o, cut_center(o, {pi / 2, 3 * pi / 2}), {pi / 2, 3 * pi / 2});
  Arc half = arcs[1];  // from the bottom, counter-clockwise over the right side, to the top
  // A curve that crosses the axis would intersect itself when swept, so it is clamped at the axis.
  double widest = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < half.points.size(); ++i)
    if (half.points[i].x() > widest) widest = half.points[i].x(), at = i;
  if (!(widest > 0) || at == 0 || at + 1 == half.points.size())
    throw Error("flat-profile", "profile " + std::to_string(o.id) + " has no area on one side of its axis",
                "choose another profile");
  for (std::size_t i = 1; i + 1 < half.points.size(); ++i)
    half.points[i].x() = std::max(half.points[i].x(), 1e-3 * widest);
  half.points.front().x() = half.points.back().x() = 0;
  const double base = half.points[at].y();
  for (auto& p : half.points) p.y() -= base;
  Halves h;
  const auto middle = static_cast<std::ptrdiff_t>(at);
  h.lower.points.assign(half.points.begin(), half.points.begin() + middle + 1);
  h.lower.corner.assign(half.corner.begin(), half.corner.begin() + middle + 1);
  h.upper.points.assign(half.points.begin() + middle, half.points.end());
  h.upper.corner.assign(half.corner.begin() + middle, half.corner.end());
  h.upper.reverse();
  return h;
}

}  // namespace

MorphFrame cylinder_frame(std::vector<Outline> profiles, const std::string& axis, int base) {
  std::stable_sort(profiles.begin(), profiles.end(), [](const Outline& a, const Outline& b) {
    return std::abs(std::log(a.aspect)) < std::abs(std::log(b.aspect));
  });
  std::rotate(profiles.begin(), profiles.begin() + base, profiles.begin() + base + 1);
  const std::vector<double> angles{0, pi / 2, pi, 3 * pi / 2};
  MorphFrame frame;
  frame.base = cut(profiles[0], cut_center(profiles[0], angles), angles);
  for (const auto& arc : frame.base) frame.radius.push_back(arc.points.front().norm());
  const Halves sweep = right_half(axis == "long" ? profiles[1].turned() : profiles[1]);
  // Scaled uniformly until it is tangent to b(0), then only in distance as it is swept along the base.
  const double scale = frame.radius[0] / sweep.upper.points.back().x();
  for (const double radius : frame.radius) {
    Arc upper = sweep.upper, lower = sweep.lower;
    for (Arc* arc : {&upper, &lower}) {
      arc->scale(scale, scale);
      arc->parametrize();  // by the sweep curve's own length: the same knots all around
      arc->scale(radius / frame.radius[0], 1);
    }
    frame.upper.push_back(std::move(upper));
    frame.lower.push_back(std::move(lower));
  }
  return frame;
}

Estimate generalized_cylinder(const EstimateRequest& request, const Work& work) {
  const int last = static_cast<int>(std::min<std::size_t>(request.chosen.size(), 3)) - 1;
  return swept_surface(cylinder_frame(request.chosen, request.axis, std::min(request.base, last)), request,
                       work);
}

}  // namespace terrazzo::shape_estimate
