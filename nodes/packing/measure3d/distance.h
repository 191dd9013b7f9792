// Distances from voxels to the nearest voxel of another phase.
#pragma once

#include <vector>

#include "nodes/packing/measure3d/classes.h"

namespace terrazzo::measure3d {

// Exact squared distance of each voxel's center to the nearest center of a voxel of another class, in units
// of the shortest edge of a voxel squared (Felzenszwalb and Huttenlocher 2012). Whole numbers if voxels are
// cubes. Periodic volumes wrap; the border of others is not another class. Infinite if there is only one
// class. Throws Error "too-large" beyond `memory` bytes.
std::vector<float> squared_distances(const Classes&, std::uint64_t memory, const Work&);

// Squared edges of the voxels in units of the shortest one's.
inline Vec3 squared_edges(const Vec3& spacing) { return (spacing / spacing.minCoeff()).cwiseAbs2(); }

}  // namespace terrazzo::measure3d
