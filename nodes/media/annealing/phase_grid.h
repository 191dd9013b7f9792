// A volume of phases.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::annealing {

// Throws Error "bad-spacing" if voxels of this edge, mm, are too small for OpenVDB.
void check_voxel(double voxel);

// A volume with the grids `phase` and `Cd`; `voxel` in mm, `color` of each phase. It tiles, or is a block
// whose first voxel is `block`.
Volume phase_volume(const std::vector<std::uint8_t>& phase, const Vec3i& size, double voxel,
                    const std::vector<Vec3f>& color, const std::optional<Vec3i>& block, const Work&);

}  // namespace terrazzo::annealing
