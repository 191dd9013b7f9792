// Convex hull of points.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

// The hull's surface, counter-clockwise seen from outside, with only the vertices that it uses. Points closer
// to it than 1e-9 of its extent may be left out. Quickhull (Barber, Dobkin, Huhdanpaa 1996). Throws Error
// "flat-points" where the points span no volume.
Mesh convex_hull(const std::vector<Vec3>& points);

}  // namespace terrazzo
