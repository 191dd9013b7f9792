// The lines of voxels along one axis of a block, x fastest.
#pragma once

#include <cstddef>

#include "nodes/data/indices.h"

namespace terrazzo::measure3d {

struct VoxelLines {
  std::size_t n, stride, count;  // voxels of a line, steps between them in memory, lines

  VoxelLines(const Vec3i& size, int axis) : n(size[axis]), stride(1), count(voxels_in(size) / n) {
    for (int a = 0; a < axis; ++a) stride *= size[a];
  }
  // The first voxel of a line. Lines next to each other in memory come next to each other.
  std::size_t start(std::size_t line) const { return line / stride * stride * n + line % stride; }
};

}  // namespace terrazzo::measure3d
