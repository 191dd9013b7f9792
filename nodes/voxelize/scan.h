// Which voxels of a lattice lie inside a closed mesh, and how much of each: exact along x, sampled in y and
// z.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

// A block of lattice cells: cell (i, j, k) is the unit cube around the centre (i, j, k).
struct CellBox {
  Vec3i lo = Vec3i::Zero(), size = Vec3i::Zero();  // first cell, number of cells
  std::size_t count() const { return static_cast<std::size_t>(size.x()) * size.y() * size.z(); }
  std::size_t index(int i, int j, int k) const {  // x fastest
    return (static_cast<std::size_t>(k - lo.z()) * size.y() + (j - lo.y())) * size.x() + (i - lo.x());
  }
};

struct Scan {
  std::vector<float> coverage;  // of each cell, 0 … 1: the mean over the lines through it, exact along them
  std::vector<std::uint8_t> inside;  // whether the cell's centre is: nonzero winding number, exact
};

// `vertices` in lattice coordinates. `lines` go along x through each cell: 1, 13, 21, 55 or 89, at the points
// of a Fibonacci lattice in y and z (all different in either, so that faces along the axes are sampled as
// finely as others), the middle one through the cell's centre. Cells outside `box` are left out. Triangles
// share their edges' intersections to the last bit, so no line leaks through an edge or a vertex.
void scan_mesh(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, const CellBox& box,
               int lines, Scan& out);

}  // namespace terrazzo
