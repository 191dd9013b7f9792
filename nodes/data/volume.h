// Volume and its grids. Include only if grids are read or made, since OpenVDB is slow to compile.
#pragma once

#include <string>

#include "nodes/data/grids.h"
#include "nodes/data/opaque_volume.h"

namespace terrazzo {

template <class Grid>
std::shared_ptr<const Grid> Volume::find(const std::string& name) const {
  for (const auto& g : grids)
    if (g->getName() == name) return openvdb::gridConstPtrCast<Grid>(g);
  return nullptr;
}

// Calls openvdb::initialize() once. Call it before creating or reading any grid.
void initialize_openvdb();
// Transform with the center of voxel (i, j, k) at (i + ½)·size, mm.
openvdb::math::Transform::Ptr voxel_transform(double size);

// The voxels that a volume consists of: one period, else its extent, else what is known of them, the active
// voxels of all grids. May be empty.
openvdb::CoordBBox voxels_of(const Volume&);
// The same for one grid of the volume: where the extent is unknown, the active voxels of this grid.
openvdb::CoordBBox voxels_of(const Volume&, const openvdb::GridBase&);

}  // namespace terrazzo
