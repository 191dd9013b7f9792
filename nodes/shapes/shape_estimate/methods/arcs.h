// Cuts curves where other curves meet them (Jagnow et al. 2008, section 3.4).
#pragma once

#include <vector>

#include "nodes/shapes/shape_estimate/outline.h"

namespace terrazzo::shape_estimate {

// A piece of an outline, both ends included.
struct Arc {
  std::vector<Vec2> points;    // mm, relative to the center of the cuts
  std::vector<double> corner;  // as in Outline
  // Normalized arc length ∫√(x′² + y′²) of each point, 0 to 1 (errata 6 in docs/errata.md).
  std::vector<double> t;

  void parametrize();  // fills t from the points
  void scale(double x, double y);
  void reverse();
  Vec2 at(double t) const;
  double corner_at(double t, double within) const;  // the strongest corner at a distance of at most `within`
};

// Cuts an outline at its outermost crossings of the rays from `center` at increasing `angles` (radians). Arc
// i runs counter-clockwise from ray i to the next one. The outermost points of distinct rays are in order
// along any simple curve around the center, star-shaped or not. `center` must be inside; throws Error
// "no-crossing" if a ray does not cross the outline.
std::vector<Arc> cut(const Outline&, const Vec2& center, const std::vector<double>& angles);

// Center of the cuts: the centroid if each ray crosses the curve only once, otherwise the nearest inner point
// with the fewest additional crossings.
Vec2 cut_center(const Outline&, const std::vector<double>& angles);

// `spans` + 1 parameters from 0 to 1: evenly spaced, but moved to the arc's strongest corners.
std::vector<double> knots(const Arc&, int spans);

}  // namespace terrazzo::shape_estimate
