// Volume: named OpenVDB grids over one box. Include it only where grids are touched: OpenVDB is slow to
// compile.
#pragma once

#include <openvdb/openvdb.h>

#include <string>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Volume {
  // Voxels of the periodic box; voxel (0, 0, 0) to resolution − 1 hold one period. Zero where not periodic.
  Vec3i resolution = Vec3i::Zero();
  // Grids with unique names. All share one transform: voxel size in mm, voxel centres at (i + ½)·voxel.
  std::vector<openvdb::GridBase::ConstPtr> grids;

  // Null where there is none of that name and type.
  template <class Grid>
  typename Grid::ConstPtr find(const std::string& name) const {
    for (const auto& g : grids)
      if (g->getName() == name) return openvdb::gridConstPtrCast<Grid>(g);
    return nullptr;
  }
};

template <>
const ValueType& value_type<Volume>();

// openvdb::initialize() once; call before any grid is made or read.
void initialize_openvdb();
// Voxel (i, j, k) centred at (i + ½)·size, mm.
openvdb::math::Transform::Ptr voxel_transform(double size);

}  // namespace terrazzo
