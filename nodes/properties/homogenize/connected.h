// Which voxels of a phase reach across the volume.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "runtime/work.h"

namespace terrazzo::homogenize {

struct Connected {
  std::vector<std::uint8_t> voxels;  // 1 in pieces that reach across along one of `axes`
  std::array<bool, 3> along{};       // whether some piece does, by axis
};

// Pieces of the voxels with open[i] = 1, connected by faces. In a periodic box a piece reaches across if a
// path leads from a voxel to its own copy; otherwise if it touches both opposite sides of the axis.
Connected connected_across(const std::vector<std::uint8_t>& open, const VoxelBox&,
                           const std::array<bool, 3>& axes, const Work&);

}  // namespace terrazzo::homogenize
