// Exemplars at several scales.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "nodes/solid_optimize/patch_space.h"

namespace terrazzo::solid_optimize {

// One picture as the synthesis takes it: rows run upwards, in whatever values.
struct SolidExemplar {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;
  std::vector<std::uint8_t> usable;  // per pixel; empty: all
  std::vector<Vec3f> features;       // carried along, per pixel; empty: none
  std::vector<float> guide;          // one more channel for patches to be matched by; empty: none
};

// Averages over each new pixel's footprint; a mask keeps what is usable through and through. Sizes may only
// shrink.
SolidExemplar shrink(const SolidExemplar&, int width, int height);

// `working` holds values of which the first `channels` count, and after them the guide on the first `guided`
// levels. Level 0 is the coarsest, the last one full size. Patch spaces keep `share` of the variance and
// `most` dimensions, on the last level `most_last`. Throws Error "exemplar-too-small" where no patch fits
// that is usable throughout.
std::vector<ExemplarLevel> exemplar_levels(const SolidExemplar& working, int channels, int guided, int levels,
                                           double share, int most, int most_last, const Work&);

// Size of level `level` of `levels`, of which the last has `full`.
inline int level_size(int full, int level, int levels) {
  const int by = 1 << (levels - 1 - level);
  return (full + by / 2) / by;
}

}  // namespace terrazzo::solid_optimize
