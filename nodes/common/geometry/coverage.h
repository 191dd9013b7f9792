// Level sets as coverage.
#pragma once

#include <memory>

#include "nodes/data/grids.h"

namespace terrazzo {

// The share of a voxel that lies inside, from the signed distance of its center to the surface, negative
// inside; both in mm. Exact for a plane across an axis.
double coverage_of(double distance, double voxel);

// The grid as a fog volume of the same name: 0 outside, active where it is above 0.
std::shared_ptr<openvdb::FloatGrid> coverage_of(const openvdb::FloatGrid& level_set);

}  // namespace terrazzo
