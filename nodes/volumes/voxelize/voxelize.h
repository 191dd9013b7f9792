// Voxelizes particles: coverage, signed distance, color and particle index in a periodic box.
#pragma once

#include "nodes/data/detail.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/volumes/voxelize/lattice.h"
#include "runtime/intermediates.h"
#include "runtime/work.h"

namespace terrazzo::voxelize {

struct VoxelReport {
  double volume_fraction = 0;                         // mean density
  double exact_volume_fraction = 0;                   // of the meshes; overlaps count twice
  double void_fraction = 0, exact_void_fraction = 0;  // the same for voids
  double overlap_fraction = 0;                        // share of the box covered more than once
  std::size_t without_voxel = 0;  // particles that contain no voxel center and are missing from `id`
  Vec3i detail_periods = Vec3i::Zero();
  Vec3 detail_scale = Vec3::Ones();
};

// Returns these grids. `residual` (a grid, see lattice_residual.h) and `detail` may be null; at most one is
// set. Throws Error "bad-particles", "open-mesh".
// density: float, share of each voxel inside solid particles, the mean over 13 to 89 lines along x.
// surface: float level set of the union, mm, half-width 3 voxels, sign exact at voxel centers.
// Cd: vec3s, scene-linear, particle and binder colors by coverage, plus the detail in sRGB-encoded values.
// id: int32, index of the particle (or void) that contains the voxel's center, the smaller if there are two;
// −1 outside. void, only if there are voids: float, like density.
Volume voxelize(const Particles&, const Shapes&, const Volume* residual, const Lattice&, VoxelReport&,
                const Work& = {}, const Detail* detail = nullptr, const Intermediates& = {});

}  // namespace terrazzo::voxelize
