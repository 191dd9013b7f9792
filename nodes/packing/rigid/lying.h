// Stones that lie as they do on the ground.
#pragma once

#include <cstddef>
#include <cstdint>

#include "nodes/data/shapes.h"
#include "nodes/packing/rigid/relaxation.h"

namespace terrazzo::packing {

// Turns the particles from `first` on so that their shortest axis points up or down, give or take
// `kTilt` (standard deviation, radians), as loose stones lie; the azimuth is uniformly random. The shortest
// axis is the principal axis of the mesh with the least variance. Balls and cubes, which have none, lie at
// random.
inline constexpr double kTilt = 0.3;
void lay_flat(Packing&, const Shapes&, std::size_t first, std::uint64_t seed);

}  // namespace terrazzo::packing
