// The cubic voxels of a periodic box.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::voxelize {

struct Lattice {
  Vec3i size = Vec3i::Zero();  // voxels
  double voxel = 0;            // mm
};

// `resolution`: voxels along the longest edge, or along each of the three edges. Voxels are cubes, so every
// edge must be a whole number of voxels, to one part in a million. Throws Error "uneven-voxels" with the
// nearest resolution that fits, "bad-box", "bad-value", "too-large" (over 4.1·10⁹ voxels).
Lattice choose_lattice(const Vec3& box, const std::vector<std::int64_t>& resolution);

}  // namespace terrazzo::voxelize
