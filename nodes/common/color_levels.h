// The few colours that stand for all of a texture's (Malzbender and Spach 1993, section 2.1).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/level_field.h"
#include "nodes/data/image.h"
#include "runtime/value.h"
#include "runtime/work.h"

namespace terrazzo {

// Where colours are compared: "oklab", or "rgb" as displays show it (the paper's), both in units in which
// black and white lie 1 (√3 in rgb) apart.
struct ColorLevels {
  bool oklab = true;
  std::vector<Vec3f> center;  // in that space, by rising first component
  std::vector<Vec3f> color;   // scene-linear

  int count() const { return static_cast<int>(center.size()); }
  Vec3f position(const Vec3f& linear) const;
  // The level nearest to a position, and its squared distance.
  int nearest(const Vec3f& position, float* distance2 = nullptr) const;
};

// k-means on at most 16,384 of the pixels, evenly picked. Throws Error "bad-pixels" where one is not finite,
// "one-color" where there are fewer than two different colours, "no-pixels".
ColorLevels color_levels(const std::vector<Vec3f>& linear, int levels, const std::string& space,
                         std::uint64_t seed, const Work& = {});

// The nearest level of every pixel of a section; kNoLevel where `mask` (one entry a pixel, or empty: all) is
// 0.
LevelField levels_of(const Image&, int section, const ColorLevels&, const std::vector<std::uint8_t>& mask,
                     const Work& = {});

// A mask from Labels (other than 0) or an Image (mean above 0.2), section by section, one entry a pixel.
// Throws Error "wrong-size" where it is not of the picture's size. `input` is its port's name.
std::vector<std::uint8_t> mask_of(const Value&, const Image& picture, const std::string& input);

}  // namespace terrazzo
