// The texture that a nib paints: the colors and co-occurrence of a region.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/texture/color_levels.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::texture_nib {

struct NibOptions {
  int levels = 8;
  int extent = 3;  // pixels: the kernel is (2·extent + 1)²
  int scales = 1;  // number of scales of the offsets: times 1, 2, 4, …
  double threshold =
      -1;  // φ: pixels farther than this from every level are ignored; below 0: derived from the region
  ColorSpace space = ColorSpace::Oklab;
  std::uint64_t seed = 1;
};

struct NibTexture {
  ColorLevels levels;
  double threshold = 0;        // in the levels' space
  std::vector<Vec3i> offsets;  // half of the kernel
  int width = 0;               // number of levels, padded to whole vectors of eight
  // Probabilities of the pairs: [offset][row, the last all 0][width], rows by the home or the remote level.
  std::vector<float> by_home, by_remote;
  std::vector<double> histogram;  // cumulative fractions of the levels
  // For the whole picture: colors, scene-linear and in the levels' space; level, or kNoLevel outside the
  // region.
  std::vector<Vec3f> colors, positions;
  std::vector<std::uint8_t> level;
  std::vector<std::vector<std::uint32_t>> pixels_of;  // the region's pixels of each level
};

// `region` has one entry per pixel of the picture's first section. Throws Error "no-pixels", "too-small" if
// the region has no pair of pixels at some offset, "one-color", "bad-pixels".
NibTexture learn(const Image&, const std::vector<std::uint8_t>& region, const NibOptions&, const Work& = {});

}  // namespace terrazzo::texture_nib
