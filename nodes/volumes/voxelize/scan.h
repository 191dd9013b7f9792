// Finds the voxels of a lattice inside a closed mesh and the covered share of each: exact along x, sampled in
// y and z.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/shapes.h"

namespace terrazzo::voxelize {

// A block of lattice cells: cell (i, j, k) is the unit cube centered at (i, j, k).
struct CellBox {
  Vec3i lo = Vec3i::Zero(), size = Vec3i::Zero();  // first cell, number of cells
  std::size_t count() const { return voxels_in(size); }
  std::size_t index(int i, int j, int k) const {  // x fastest
    return (static_cast<std::size_t>(k - lo.z()) * size.y() + (j - lo.y())) * size.x() + (i - lo.x());
  }
};

struct Scan {
  std::vector<float> coverage;       // per cell, 0 … 1: mean over the lines through it, exact along each
  std::vector<std::uint8_t> inside;  // whether the cell's center has a nonzero winding number; exact
};

// `vertices` are in lattice coordinates. Each cell is crossed by `lines` lines along x (1, 13, 21, 55 or 89)
// at the points of a Fibonacci lattice in y and z. All their y and all their z differ, so that axis-aligned
// faces are sampled as finely as others. The middle line goes through the cell's center. Cells outside `box`
// are omitted. Triangles share the intersections of common edges to the last bit, so no line leaks through an
// edge or a vertex.
void scan_mesh(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, const CellBox& box,
               int lines, Scan& out);

}  // namespace terrazzo::voxelize
