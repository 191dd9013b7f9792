// How much of a phase is connected across the box.
#pragma once

#include <array>
#include <vector>

#include "nodes/packing/measure3d/classes.h"

namespace terrazzo::measure3d {

// Of the voxels of one class. Pieces are connected by faces of voxels (6 neighbors).
struct Percolation {
  // Share in pieces that reach across along x, y, z: in a periodic volume those in which a path leads to its
  // own copy in another period along the axis, in others those that touch both opposite sides of the box.
  std::array<double, 3> across{};
  double largest = 0;  // share in the largest piece
  std::size_t pieces = 0;
};

// By class; all zero for one without voxels. Throws Error "too-large" beyond `memory` bytes.
std::vector<Percolation> percolation_of(const Classes&, std::uint64_t memory, const Work&);

}  // namespace terrazzo::measure3d
