// Texture synthesis from noise by matching a picture's color co-occurrence matrix (Malzbender and Spach 1993,
// section 3).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/texture/coarse_descent.h"
#include "nodes/common/texture/color_levels.h"
#include "nodes/common/texture/cooccurrence.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::cooccurrence_synth {

enum class Finish {
  Levels,  // the clustered colors
  Patches  // the source's own colors (patches.h)
};

struct SynthOptions {
  int levels = 8;
  int extent = 2;             // pixels: offsets up to ± this in x and y
  int scales = 1;             // number of scales of the offsets: times 1, 2, 4, …
  int sweeps = 10;            // most sweeps at each resolution; ends early when a sweep changes nothing
  int width = 0, height = 0;  // pixels; 0: the source's
  bool tileable = true;       // opposite edges are neighbors
  ColorSpace space = ColorSpace::Oklab;  // for clustering
  Start start = Start::Coarse;
  Finish finish = Finish::Levels;
  std::uint64_t seed = 1;
};

struct SynthResult {
  ColorLevels levels;
  LevelField field;
  double noise_error = 0;            // E of the noise
  std::vector<DescentSweep> sweeps;  // from coarse to fine
  std::vector<std::uint32_t>
      from;                   // with patches, for each pixel: the source pixel that its color comes from
  double finished_error = 0;  // E of the final field
};

// `mask` selects the source pixels to use, one entry each; empty: all. Throws Error "too-small" if the source
// or the output is no larger than the reach of the offsets, "no-pairs", "one-color", "no-pixels",
// "bad-pixels".
SynthResult synthesize(const Image& source, const std::vector<std::uint8_t>& mask, const SynthOptions&,
                       const Work& = {});

// A field, or the first section of a source, in its levels' colors.
Image image_of(const LevelField&, const ColorLevels&, double pixel_size);

}  // namespace terrazzo::cooccurrence_synth
