// Photographs taken at an angle, as if taken from straight above.
#pragma once

#include <cstdint>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::load_image {

// How a pinhole camera looked at a plane surface.
struct TiltOptions {
  double tilt = 0;            // degrees between the camera's axis and the surface's normal, 0 to 60
  double direction = 90;      // degrees, where in the picture the surface recedes: 0 right, 90 up
  double field_of_view = 60;  // degrees across the picture's longer side
};

// One section, projected onto the surface. A pixel of the result is as wide on the surface as a pixel in the
// middle of the photograph is across the direction of the tilt. The result is the largest upright rectangle
// that the photograph covers. `memory`: bytes that may be used. Throws Error "bad-value" of the parameter
// tilt if the picture reaches to 85° from the normal or beyond (the horizon is at 90°), "too-large",
// "too-small".
Image rectified(const Image&, const TiltOptions&, std::uint64_t memory, const Work&);

}  // namespace terrazzo::load_image
