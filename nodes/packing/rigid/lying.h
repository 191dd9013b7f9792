// Stones that lie as they do on the ground.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/packing/rigid/relaxation.h"

namespace terrazzo::packing {

// Turns the particles from `first` on so that their shortest axis points up or down, give or take
// kTilt, as loose stones lie (common/geometry/mesh/shortest_axis.h); the long axis points in one of
// the directions in `long_axes`, radians from x, or in any if there are none. Balls and cubes, which have no
// shortest axis, lie at random. Traced shapes lie as their stones did in the photograph, give or take 0.15
// radians about the upright and 0.1 to the sides.
void lay_flat(Packing&, const Shapes&, std::size_t first, const std::vector<double>& long_axes,
              std::uint64_t seed);

}  // namespace terrazzo::packing
