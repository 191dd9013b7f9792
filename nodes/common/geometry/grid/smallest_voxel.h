// The smallest voxels that a grid can have.
#pragma once

namespace terrazzo {

// OpenVDB takes smaller voxels for singular. A cube of this volume has an edge of 15 nm.
constexpr double kSmallestVoxel = 3.1e-15;  // mm³

}  // namespace terrazzo
