// Curves as radii along evenly spaced rays from the origin, the first along x.
#pragma once

#include <vector>

#include "nodes/common/geometry/mesh/loop.h"

namespace terrazzo::shape_estimate {

// Raises the radii of the rays that the segment from `a` to `b` crosses to where it crosses them.
void raise_radii(std::vector<double>& radii, const Vec2& a, const Vec2& b);

// The closed polygon of the rays' ends, counterclockwise.
Loop loop_of_radii(const std::vector<double>& radii);

}  // namespace terrazzo::shape_estimate
