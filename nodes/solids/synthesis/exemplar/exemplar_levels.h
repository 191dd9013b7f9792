// Exemplars at several scales.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/solids/synthesis/exemplar/patch_space.h"

namespace terrazzo::solids {

// One picture as input to the synthesis. Rows run upwards; pixels may hold any three values.
struct SolidExemplar {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;
  std::vector<std::uint8_t> usable;  // per pixel; empty: all
  std::vector<Vec3f> features;       // carried along, per pixel; empty: none
  std::vector<float> guide;          // extra channel for patch matching; empty: none
};

// Averages over each new pixel's footprint. A pixel stays usable only if its whole footprint is. Sizes may
// only shrink.
SolidExemplar shrink(const SolidExemplar&, int width, int height);

// Builds all levels: level 0 is the coarsest, the last has full size. The first `channels` values of
// `working` are used, and the guide on the first `guided` levels. Patch spaces keep `share` of the variance
// in at most `most` dimensions, `most_last` on the last level. Throws Error "exemplar-too-small" if a level
// has fewer than 16 fully usable patches.
std::vector<ExemplarLevel> exemplar_levels(const SolidExemplar& working, int channels, int guided, int levels,
                                           double share, int most, int most_last, const Work&);

// Size of level `level` of `levels`, where the last level has size `full`.
inline int level_size(int full, int level, int levels) {
  const int by = 1 << (levels - 1 - level);
  return (full + by / 2) / by;
}

}  // namespace terrazzo::solids
