// Convex hulls of points in a plane.
#pragma once

#include "nodes/common/geometry/mesh/loop.h"

namespace terrazzo {

// The corners of the convex hull, counterclockwise (Andrew 1979); empty for fewer than three points.
Loop hull_of(Loop points);

}  // namespace terrazzo
