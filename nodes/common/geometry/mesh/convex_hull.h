// Convex hull of points.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

// The hull's surface, counterclockwise seen from outside, with used vertices only. May omit points closer to
// the hull than 1e-9 of its extent; if the hull is ambiguous, the tolerance grows to at most 1e-3. Quickhull
// (Barber, Dobkin, Huhdanpaa 1996). Throws Error "flat-points" if the points do not span a volume, "no-hull"
// if no tolerance succeeds.
Mesh convex_hull(const std::vector<Vec3>& points);

}  // namespace terrazzo
