// Texture from noise by matching a picture's colour co-occurrence matrix (Malzbender and Spach 1993, section
// 3).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/coarse_descent.h"
#include "nodes/common/color_levels.h"
#include "nodes/common/cooccurrence.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::cooccurrence_synth {

struct SynthSettings {
  int levels = 8;
  int extent = 2;               // pixels: offsets up to ± this in x and y
  int scales = 1;               // of the offsets: times 1, 2, 4, …
  int sweeps = 10;              // of each resolution, at most; it ends when one changes nothing
  int width = 0, height = 0;    // pixels; 0: the source's
  bool tileable = true;         // opposite edges are neighbours
  std::string space = "oklab";  // or rgb: where colours are clustered
  bool from_noise = false;      // at full resolution alone (the paper's), not from coarse to fine
  bool patches = false;         // ends in the source's own colours (patches.h)
  std::uint64_t seed = 1;
};

struct SynthResult {
  ColorLevels levels;
  LevelField field;
  double noise_error = 0;            // E of noise
  std::vector<DescentSweep> sweeps;  // from coarse to fine
  std::vector<std::uint32_t> from;   // of each pixel, with patches: the source's pixel whose colour it has
  double finished_error = 0;         // E of the field as it is in the end
};

// `mask`: which pixels of the source count, one entry each, or empty. Throws Error "too-small" where the
// source or the output is no larger than the offsets reach, "no-pairs", "one-color", "no-pixels",
// "bad-pixels".
SynthResult synthesize(const Image& source, const std::vector<std::uint8_t>& mask, const SynthSettings&,
                       const Work& = {});

// The first section, or a field, in its levels' colours.
Image image_of(const LevelField&, const ColorLevels&, double pixel_size);

}  // namespace terrazzo::cooccurrence_synth
