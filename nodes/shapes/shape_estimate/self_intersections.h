// Counts the self-intersections of a mesh.
#pragma once

#include <cstdint>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Number of pairs of triangles that intersect, other than at shared corners. Pairs that share an edge
// are not tested; contact within rounding may or may not count. A uniform grid finds the pairs: O(n)
// for evenly sized triangles.
std::int64_t self_intersections(const Mesh&, const Work& = {});

}  // namespace terrazzo::shape_estimate
