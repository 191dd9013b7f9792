// Materials made up of noise, as solids that a plane cuts.
#pragma once

#include <cstdint>
#include <string>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::pattern {

struct PatternChoice {
  std::string kind = "wood";  // wood, marble, muscle, fat, bone
  std::string axis = "x";     // the plane lies across it; z is up on x and y
  double offset = 0;          // mm along the axis
  int width = 128, height = 128;
  double pixel_size = 0.1;  // mm
  double scale = 2;         // mm: a ring's width, the distance of veins, a bundle's or lobule's diameter
  std::uint64_t seed = 1;
};

// Scene-linear colour of a point, mm. Wood's rings run round, and its fibres and muscle's along, the z axis.
Vec3f pattern_color(const PatternChoice&, const Vec3& point);
// The section, antialiased by 2 × 2 samples a pixel.
Image pattern_image(const PatternChoice&, const Work& = {});

}  // namespace terrazzo::pattern
