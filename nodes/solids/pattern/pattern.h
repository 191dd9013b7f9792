// Procedural solid materials, seen in a plane section.
#pragma once

#include <cstdint>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::pattern {

enum class Kind { Wood, Marble, Muscle, Fat, Bone, Sandstone, Electrode, Copolymer };

struct PatternOptions {
  Kind kind = Kind::Wood;
  int axis = 0;       // normal to the plane: x, y, z; z is up on x and y
  double offset = 0;  // mm along the axis
  int width = 128, height = 128;
  double pixel_size = 0.1;  // mm
  double scale = 2;  // mm: width of a ring, distance of veins, diameter of a bundle, lobule or grain, wave
  std::uint64_t seed = 1;
};

// Scene-linear color at a point in mm. Wood's rings run around the z axis; its fibers and those of muscle run
// along z.
Vec3f pattern_color(const PatternOptions&, const Vec3& point);
// The section, antialiased by 2 × 2 samples per pixel.
Image pattern_image(const PatternOptions&, const Work& = {});

}  // namespace terrazzo::pattern
