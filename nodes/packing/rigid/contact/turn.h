// Spheres are packed as spheres, although the corners of their mesh's facets extend beyond. Each sphere is
// rotated so that no corner extends beyond the plane between it and a neighbor.
#pragma once

#include <cstdint>

#include "nodes/packing/rigid/relaxation.h"

namespace terrazzo::packing {

// Rotates the spheres whose mesh extends beyond its share of the distance (less `gap`, mm) to another sphere,
// randomly, until the plane between the two separates them. All are rotated in parallel. The few without a
// suitable rotation after some thousand tries are then rotated one at a time and may use what their neighbors
// leave. Positions do not change.
void turn_spheres(const Shapes& meshes, const std::vector<ContactShape>& shapes, Packing& packing, double gap,
                  std::uint64_t seed, const Work& work);

}  // namespace terrazzo::packing
