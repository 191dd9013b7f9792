// Raster tessellations for Neper (.tesr, version 2.1). Lengths in mm, orientations as Bunge's Euler angles in
// degrees.
#pragma once

#include <filesystem>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/particles.h"
#include "nodes/export/formats/solvers/materials.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// Regions 1, 2, … are cells; voxels of region 0 are empty. `particles` and `materials` may be null: they add
// orientations and, if all cells have the same of those that Neper knows, the crystal's symmetry. Throws
// Error "no-particles", "no-material", "write-failed".
void write_tesr(const std::filesystem::path&, const VoxelSource& id, const VoxelBox&, const Regions&,
                const Particles*, const SolverMaterials*, const Work& = {});

}  // namespace terrazzo::exporting
