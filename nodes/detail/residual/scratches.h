// Scratches of polishing in a picture.
#pragma once

#include <cstdint>
#include <span>

#include "nodes/detail/residual/camera_noise.h"
#include "runtime/work.h"

namespace terrazzo::residual {

// Adds the photograph's scratches at random places, each in its own direction and as often per area as in the
// photograph, to scene-linear pixels, row by row from the top. `cover`: how much of a pixel particles cover;
// the other arguments are those of add_noise.
void add_scratches(Vec3f* pixels, std::span<const float> cover, int width, int height, double pixel,
                   bool wrap, const Camera&, std::uint64_t picture, const Work&);

}  // namespace terrazzo::residual
