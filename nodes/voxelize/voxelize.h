// Particles as grids: coverage, signed distance, colour and index of every voxel of the periodic box.
#pragma once

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/volume.h"
#include "nodes/voxelize/lattice.h"
#include "runtime/work.h"

namespace terrazzo {

struct VoxelReport {
  double volume_fraction = 0;                         // mean density
  double exact_volume_fraction = 0;                   // of the meshes, overlaps counted twice
  double void_fraction = 0, exact_void_fraction = 0;  // the same of the voids
  double overlap_fraction = 0;                        // share of the box that particles cover more than once
  std::size_t without_voxel = 0;  // particles that hold no voxel's centre: absent from `id`
  Vec3i detail_periods = Vec3i::Zero();
  Vec3 detail_scale = Vec3::Ones();
};

// Grids density (float, share of each voxel inside particles with matter: the mean over
// 13 to 89 lines along x), surface (float level set of the union, mm, 3 voxels wide, sign exact at voxel
// centres), Cd (vec3s, scene-linear; particles' and binder's colours by coverage, plus the detail in
// sRGB-encoded values), id (int32, index of the particle that holds the voxel's centre, the smaller where two
// do; −1 outside; voids count), and where there are voids void (float, as density). `residual` may be null.
// Throws Error "bad-particles", "open-mesh".
Volume voxelize(const Particles&, const Shapes&, const Volume* residual, const Lattice&, VoxelReport&,
                const Work& = {});

}  // namespace terrazzo
