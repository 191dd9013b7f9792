// Curves cut where others are to meet them (Jagnow et al. 2008, 3.4).
#pragma once

#include <vector>

#include "nodes/shape_estimate/outline.h"

namespace terrazzo::shape_estimate {

// A piece of an outline, both ends included.
struct Arc {
  std::vector<Vec2> points;    // mm, relative to the centre of the cuts
  std::vector<double> corner;  // as in Outline
  std::vector<double> t;  // normalised arc length of each point, 0 to 1 (ERRATA: ∫√(x′² + y′²))

  void parametrise();  // fills t from the points
  void scale(double x, double y);
  void reverse();
  Vec2 at(double t) const;
  double corner_at(double t, double within) const;  // the strongest corner at most `within` away
};

// Cuts an outline at its outermost crossings of the rays from `center` at rising `angles` (radians). Arc i
// runs from ray i to the next one, counter-clockwise. The outermost points of distinct rays follow each other
// along any simple curve about the centre, star-shaped or not. Needs a centre inside.
std::vector<Arc> cut(const Outline&, const Vec2& center, const std::vector<double>& angles);

// Where to cut from: the centroid where each ray leaves the curve just once, else the inner point nearest to
// it with the fewest further crossings.
Vec2 cut_center(const Outline&, const std::vector<double>& angles);

// `spans` + 1 parameters from 0 to 1: evenly spaced, but drawn to the arc's strongest corners.
std::vector<double> knots(const Arc&, int spans);

}  // namespace terrazzo::shape_estimate
