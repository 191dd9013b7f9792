// The colors of a volume that tiles.
#pragma once

#include <string>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/solids/patch_fill/torus.h"

namespace terrazzo::patch_fill {

// `input` names the volume in messages. Throws the errors of voxel_box(), and "not-periodic" and "too-small"
// (fewer than 16 voxels along an axis).
VoxelBox solid_box(const Volume&, const std::string& input);
// Grid Cd, scene-linear. Throws the errors of VoxelSource, and "no-color".
Torus<Vec3f> read_solid(const Volume&, const VoxelBox&, const std::string& input);

}  // namespace terrazzo::patch_fill
