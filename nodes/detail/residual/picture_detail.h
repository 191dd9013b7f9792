// The detail of particles and binder in a picture of a plane.
#pragma once

#include <cstdint>
#include <span>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::residual {

class ResidualField;

// A picture with square or oblong pixels on a plane: the point u to the right and v upwards from its lower
// left corner, in mm, is at origin + u·right + v·up.
struct PicturePlane {
  int width = 0, height = 0;  // pixels
  double mm_x = 1, mm_y = 1;  // of a pixel
  bool wrap = false;          // opposite edges join
  Vec3 origin = Vec3::Zero(), right = Vec3::UnitX(), up = Vec3::UnitY();
  std::span<const float> above = {};  // height of each pixel along right × up, mm; empty: 0
};

// Adds the detail to scene-linear pixels, row by row from the top. `ids`: 0 outside of particles, any numbers
// that tell them apart within; outlines lie between different ids. `owner`: the particle in the field, −1 if
// none; `cover`: how much of the pixel it covers, at most 1 counts.
void add_to_picture(Vec3f* pixels, const PicturePlane&, std::span<const std::int32_t> ids,
                    std::span<const std::int32_t> owner, std::span<const float> cover, const ResidualField&,
                    const Work&);

}  // namespace terrazzo::residual
