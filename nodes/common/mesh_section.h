// Exact plane sections of closed meshes.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

using Loop =
    std::vector<Vec2>;  // closed polygon, not repeated; outer loops counter-clockwise, holes clockwise

double loop_area(const Loop&);  // signed
double loop_perimeter(const Loop&);

// The section of `mesh` by the plane {x : u·x = h} in the coordinates (a·x, b·x), where a, b, u are the
// columns of a rotation. Vertices on the plane count as above it, so that every section is a set of closed
// loops. Empty where the plane misses.
std::vector<Loop> section_loops(const Mesh& mesh, const Mat3& a_b_u, double h);

// Loops grouped into disjoint profiles: each an outer loop first, then its holes. Loops without area, and
// holes outside every outer loop (only a surface that cuts itself has them), are left out.
std::vector<std::vector<Loop>> section_profiles(std::vector<Loop> loops);

}  // namespace terrazzo
