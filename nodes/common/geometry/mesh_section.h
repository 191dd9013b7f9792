// Exact plane sections of closed meshes.
#pragma once

#include <vector>

#include "nodes/common/geometry/loop.h"
#include "nodes/data/shapes.h"

namespace terrazzo {

// The section of `mesh` by the plane {x : u·x = h} in the coordinates (a·x, b·x), where a, b, u are the
// columns of a rotation. Vertices on the plane count as above it, so that every section is a set of closed
// loops. Empty if the plane misses the mesh.
std::vector<Loop> section_loops(const Mesh& mesh, const Mat3& a_b_u, double h);

// Groups loops into disjoint profiles: each has an outer loop first, then its holes. Loops without area are
// dropped, and so are holes outside every outer loop, which occur only in self-intersecting surfaces.
std::vector<std::vector<Loop>> section_profiles(std::vector<Loop> loops);

}  // namespace terrazzo
