// Adds detail to the colors of a voxelized packing.
#pragma once

#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo {
struct Detail;
}

namespace terrazzo::detail_solid {

// `volume`: Voxelize's grids Cd, id and density, periodic. Returns its grids with a new Cd: in every voxel,
// the offsets of its particle and of the binder in proportion to the density. A particle's group is that of
// the mean color of its whole voxels. Throws Error "no-color", "no-id", "not-periodic".
Volume add_detail(const Volume& volume, const Detail& detail, const Work& = {});

}  // namespace terrazzo::detail_solid
