// Volume: named OpenVDB grids in one box. Include only if grids are used, since OpenVDB is slow to compile.
#pragma once

#include <openvdb/openvdb.h>

#include <string>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Volume {
  // Resolution of the periodic box in voxels: one period contains the voxels (0, 0, 0) to resolution − 1.
  // Zero if not periodic.
  Vec3i resolution = Vec3i::Zero();
  // Grids with unique names. They share one transform: voxel size in mm, voxel centers at (i + ½)·voxel.
  std::vector<openvdb::GridBase::ConstPtr> grids;

  // Returns null if there is no grid of that name and type.
  template <class Grid>
  typename Grid::ConstPtr find(const std::string& name) const {
    for (const auto& g : grids)
      if (g->getName() == name) return openvdb::gridConstPtrCast<Grid>(g);
    return nullptr;
  }
};

template <>
const ValueType& value_type<Volume>();

// Calls openvdb::initialize() once. Call it before creating or reading any grid.
void initialize_openvdb();
// Transform with the center of voxel (i, j, k) at (i + ½)·size, mm.
openvdb::math::Transform::Ptr voxel_transform(double size);

}  // namespace terrazzo
