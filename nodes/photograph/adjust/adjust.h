// Crop, levels, hue and saturation of a picture.
#pragma once

#include <array>
#include <optional>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::adjust {

struct AdjustOptions {
  std::optional<std::array<int, 4>> crop;  // left, top, width, height in pixels
  double black = 0, white = 1;             // brightness, sRGB-encoded, that becomes 0 and 1
  double gamma = 1;                        // above 1: the middle grows lighter
  double hue = 0;                          // degrees
  double saturation = 1;                   // 0: gray
};

// The crop comes first, then levels, then colors. The part keeps its coordinates on the map. Throws Error
// "empty-image", "bad-region": the crop leaves the picture.
Image adjust_image(const Image&, const AdjustOptions&, const Work&);

}  // namespace terrazzo::adjust
