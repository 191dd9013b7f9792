// The binder's fine detail at the voxels of a slab. It does not depend on colors, so it is kept while they
// change.
#pragma once

#include <algorithm>
#include <vector>

#include "nodes/detail/residual/residual_field.h"
#include "nodes/volumes/voxelize/slab.h"
#include "runtime/work.h"

namespace terrazzo::voxelize {

// The center in mm of cell `at` of plane z.
inline Vec3f center_of(const Slab& slab, std::size_t at, int z, double voxel) {
  const std::size_t nx = slab.lattice.x();
  return ((Vec3(static_cast<double>(at % nx), static_cast<double>(at / nx), z).array() + 0.5) * voxel)
      .matrix()
      .cast<float>();
}

// How much of a voxel the particles with the grid's id cover.
inline float cover_of(const Slab& slab, std::size_t voxel) {
  return slab.id[voxel] < 0 ? 0 : std::min(slab.coverage[voxel], 1.0f);
}

struct BinderDetail {
  BinderDetail(const residual::ResidualField&, const Slab&, double voxel, const Work&);

  // Of each plane, the offsets of the voxels that no particle covers whole, x fastest.
  std::vector<std::vector<Vec3f>> planes;

  std::size_t bytes() const;
};

}  // namespace terrazzo::voxelize
