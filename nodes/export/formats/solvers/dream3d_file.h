// Microstructures for DREAM3D, DREAM3D-NX and DAMASK (.dream3d): HDF5 in the layout of DREAM3D 6.5 (file
// version 7.0). Lengths are micrometers: 1 mm is 1000.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/particles.h"
#include "nodes/export/formats/solvers/materials.h"
#include "nodes/export/regions.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

struct Dream3dContent {
  VoxelBox box;
  std::vector<VoxelSource> grids;  // cell data under the grids' names, int32 or float
  const VoxelSource* id =
      nullptr;  // with `regions`, adds FeatureIds and Phases, and data of features and phases
  const Regions* regions = nullptr;
  const Particles* particles = nullptr;        // adds orientations, sizes and colors of features
  std::string provenance;                      // JSON for /Terrazzo/Provenance, or empty
  bool compress = true;                        // cell data, by zlib
  const SolverMaterials* materials = nullptr;  // adds names and crystal structures of phases
};

// Feature and phase 0 are the binder, which DREAM3D leaves out of statistics. The group of the geometry has
// the attribute Period (three int64, voxels) if the volume tiles. Throws Error "bad-names" if a grid has the
// name of other cell data, no name, or a slash or control character in it, "too-large" (a length that floats
// cannot hold), "no-material" (`materials` lack a phase), "write-failed".
void write_dream3d(const std::filesystem::path&, const Dream3dContent&, const Work& = {});

}  // namespace terrazzo::exporting
