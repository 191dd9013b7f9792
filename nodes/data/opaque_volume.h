// Volume for files that only pass volumes on. It compiles in a tenth of the time of volume.h, which reads
// grids.
#pragma once

#include <openvdb/version.h>

#include <memory>
#include <string>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/value.h"

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
class GridBase;
}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb

namespace terrazzo {

// Named OpenVDB grids in one box.
struct Volume {
  // Resolution of the periodic box in voxels: one period contains the voxels (0, 0, 0) to resolution − 1.
  // Zero if not periodic.
  Vec3i resolution = Vec3i::Zero();
  // Grids with unique names. They share one transform: voxel size in mm, voxel centers at (i + ½)·voxel.
  std::vector<std::shared_ptr<const openvdb::GridBase>> grids;
  // If it is not periodic: the voxels that were given or made, active or not, from `first` to first + extent
  // −
  // 1. Zero if unknown, as for OpenVDB files of other programs. voxels_of() in volume.h respects both.
  Vec3i first = Vec3i::Zero(), extent = Vec3i::Zero();

  bool periodic() const { return resolution.minCoeff() > 0; }
  bool has_extent() const { return !periodic() && extent.minCoeff() > 0; }

  // Returns null if there is no grid of that name and type. Defined in volume.h.
  template <class Grid>
  std::shared_ptr<const Grid> find(const std::string& name) const;
};

template <>
const ValueType& value_type<Volume>();

}  // namespace terrazzo
