#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/methods/morph_frame.h"

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
    if (half.points[i].x() > widest) {
      widest = half.points[i].x();
      at = i;
    }
  if (!(widest > 0) || at == 0 || at + 1 == half.points.size())
    throw Error("flat-profile", "profile " + std::to_string(o.id) + " has no area on one side of its axis",
                "choose another profile");
  for (std::size_t i = 1; i + 1 < half.points.size(); ++i)
    half.points[i].x() = std::max(half.points[i].x(), 1e-3 * widest);
  half.points.front().x() = half.points.back().x() = 0;
  const double base = half.points[at].y();
  for (auto& p : half.points) p.y() -= base;
  Halves h;
  const std::ptrdiff_t middle = at;
  h.lower.points.assign(half.points.begin(), half.points.begin() + middle + 1);
  h.lower.corner.assign(half.corner.begin(), half.corner.begin() + middle + 1);
  h.upper.points.assign(half.points.begin() + middle, half.points.end());
  h.upper.corner.assign(half.corner.begin() + middle, half.corner.end());
  h.upper.reverse();
  return h;
}

// Differences of |log scale| that are rounding errors.
constexpr double kTie = 1e-9;

// A sweep curve, the half-plane on whose radius it stands, and the scale that makes it meet the base there.
struct Placement {
  Halves sweep;
  std::size_t at = 0;
  double scale = std::numeric_limits<double>::infinity();
};

// Stands on the half-plane that needs the least scaling.
Placement placed(const Outline& o, const std::vector<double>& radius) {
  Placement out;
  out.sweep = right_half(o);
  const double own = out.sweep.upper.points.back().x();
  for (std::size_t j = 0; j < radius.size(); ++j)
    if (std::abs(std::log(radius[j] / own)) < std::abs(std::log(out.scale)) - kTie) {
      out.at = j;
      out.scale = radius[j] / own;
    }
  return out;
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
  // The sweep curve keeps its size as far as possible: it stands where it belongs if both profiles are
  // central sections of one body. Ties go to lying and to the first half-plane.
  Placement best;
  std::optional<Error> flat;
  for (const bool upright : {false, true}) {
    if (upright ? axis == "short" : axis == "long") continue;
    try {
      const Placement p = placed(upright ? profiles[1].turned() : profiles[1], frame.radius);
      if (std::abs(std::log(p.scale)) < std::abs(std::log(best.scale)) - kTie) best = p;
    } catch (const Error& e) {
      flat = e;  // the other orientation may have area on that side of the axis
    }
  }
  if (!std::isfinite(best.scale) && flat) throw *flat;
  // Scaled uniformly until it is tangent to the base there, then only in distance as it is swept along the
  // base.
  for (const double radius : frame.radius) {
    Arc upper = best.sweep.upper, lower = best.sweep.lower;
    for (Arc* arc : {&upper, &lower}) {
      arc->scale(best.scale, best.scale);
      arc->parametrize();  // by the sweep curve's own length: the same knots all around
      arc->scale(radius / frame.radius[best.at], 1);
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
