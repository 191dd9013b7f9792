// Closed polygons in the plane.
#pragma once

#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo {

using Loop = std::vector<Vec2>;  // closed polygon, first point not repeated; outer loops counterclockwise,
                                 // holes clockwise

inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
double turn_between(const Vec2& before, const Vec2& after);  // angle, −π to π; > 0 to the left

double loop_area(const Loop&);  // signed
double loop_perimeter(const Loop&);
bool loop_contains(const Loop&, const Vec2& p);  // by crossings, whatever the orientation
// The corners of the convex hull, counterclockwise (Andrew 1979); empty for fewer than three points.
Loop hull_of(Loop points);
double hull_area(Loop points);

}  // namespace terrazzo
