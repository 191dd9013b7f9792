// How bright a lit picture of a bed is.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/bodies/view/surface_view.h"

namespace terrazzo::view {

// What is known of each pixel of a picture before its light is. Stones at or below `ground` are in the shadow
// between loose stones.
struct UnlitPixels {
  const std::vector<std::int32_t>& stone;  // −1: soil
  const std::vector<float>& height;        // mm
  const std::vector<Vec3f>& color;         // without light
  const std::vector<float>& sun;  // light of the sun, and of the open sky, each relative to level ground
  const std::vector<float>& sky;  // in the open
  float ground = 0;               // mm
  int width = 1;                  // pixels
  float albedo = 0;               // mean reflectance of the stones, below 1

  // Whether a pixel shows a stone, not in the shadow between loose ones.
  bool lit_stone(std::size_t pixel) const { return stone[pixel] >= 0 && height[pixel] > ground; }
};

// What each pixel's color is multiplied with. The sun gets the share of the light with which lightness grows
// across stones as in the photograph (SurfaceOptions::slope), or that of options.light without it. Stones are
// as bright on average as in the photograph, and differ as much, and soil has its color. Shadows of loose
// stones are deepened or lightened until the darkest pixels are as dark as the photograph's tones.
std::vector<float> exposure(const UnlitPixels&, const SurfaceOptions&, const Work&);

}  // namespace terrazzo::view
