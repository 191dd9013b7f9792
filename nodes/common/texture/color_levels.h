// Quantization of a texture to a few colors (Malzbender and Spach 1993, section 2.1).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/texture/level_field.h"
#include "nodes/data/image.h"
#include "nodes/data/indices.h"
#include "runtime/value.h"
#include "runtime/work.h"

namespace terrazzo {

// The color space of comparisons: Oklab, or display RGB (sRGB) as in the paper. The distance of black and
// white is 1 (√3 in RGB).
enum class ColorSpace { Oklab, Rgb };

struct ColorLevels {
  ColorSpace space = ColorSpace::Oklab;
  std::vector<Vec3f> center;  // in that space, by increasing first component
  std::vector<Vec3f> color;   // scene-linear

  int count() const { return count_of(center); }
  Vec3f position(const Vec3f& linear) const;
  // The level nearest to a position, and its squared distance.
  int nearest(const Vec3f& position, float* distance2 = nullptr) const;
};

// k-means on at most 16,384 evenly selected pixels. Throws Error "bad-pixels" if one is not finite,
// "one-color" if there are fewer than two different colors, "no-pixels".
ColorLevels color_levels(const std::vector<Vec3f>& linear, int levels, ColorSpace, std::uint64_t seed,
                         const Work& = {});

// The nearest level of every pixel of a section; kNoLevel where `mask` is 0. `mask` has one entry per pixel
// of the stack, or is empty (all pixels).
LevelField levels_of(const Image&, int section, const ColorLevels&, const std::vector<std::uint8_t>& mask,
                     const Work& = {});

// A mask from Labels (not 0) or an Image (mean above 0.2), with one entry per pixel of all sections. A mask
// of one section applies to every section. Throws Error "wrong-size" if the sizes differ. `input` is the
// port's name.
std::vector<std::uint8_t> mask_of(const Value&, const Image& picture, const std::string& input);

}  // namespace terrazzo
