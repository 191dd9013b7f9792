// How often a mesh passes through itself.
#pragma once

#include <cstdint>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Pairs of triangles that cut each other, other than along shared corners. Pairs that share an edge are not
// tested; touching within rounding may count or not. A uniform grid finds the pairs: O(n) for even meshes.
std::int64_t self_intersections(const Mesh&, const Work& = {});

}  // namespace terrazzo::shape_estimate
