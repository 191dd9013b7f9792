// Areas of surfaces between voxels, by counting crossings along 13 directions.
#pragma once

#include <vector>

#include "nodes/packing/measure3d/bodies.h"
#include "nodes/packing/measure3d/raster.h"

namespace terrazzo::measure3d {

struct VoxelSurfaces {
  double phase = 0;            // between the phase and the rest, mm²
  std::vector<Touch> touches;  // pairs of labels that share voxel faces, with the area between them
};

// Cauchy–Crofton: an area is twice its crossings per length, averaged over directions, times the volume. The
// directions are those from a voxel to its 26 neighbors, weighted by the solid angles that they are closest
// to (Ohser and Mücklich 2000, chapter 4). Volumes that do not tile have no surface at their border.
VoxelSurfaces voxel_surfaces(const Raster&, const Work&);

}  // namespace terrazzo::measure3d
