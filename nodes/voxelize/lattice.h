// The cubic voxels of a periodic box.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"

namespace terrazzo {

struct Lattice {
  Vec3i size = Vec3i::Zero();  // voxels
  double voxel = 0;            // mm
};

// One number: voxels along the longest edge; three: along each. Voxels are cubes, so the other edges must be
// whole numbers of them, to one part in a million. Throws Error "uneven-voxels" with the nearest resolution
// that fits, "bad-box".
Lattice choose_lattice(const Vec3& box, const std::vector<std::int64_t>& resolution);

}  // namespace terrazzo
