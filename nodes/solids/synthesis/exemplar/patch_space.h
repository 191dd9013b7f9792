// 8 × 8 patches of a picture as points in a low-dimensional space.
#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::solids {

constexpr int kPatch = 8;

// Aligned to cache lines, so that a patch of 16 dimensions fills exactly one.
using AlignedFloats = std::vector<float, tbb::cache_aligned_allocator<float>>;

// Principal axes of patches of interleaved channels.
struct PatchSpace {
  int channels = 0, dims = 0;  // dims is a multiple of 16
  AlignedFloats basis;         // [64·channels][dims]: element k = (row·8 + column)·channels + channel
  std::vector<float> bias;     // [dims]: the mean patch's coordinates
};

// One scale of an exemplar. Rows run upwards; texel (x, y) is number y·width + x.
struct ExemplarLevel {
  int width = 0, height = 0, channels = 0;
  std::vector<float> texels;          // 4 per texel; channels beyond `channels` are 0
  std::vector<std::uint8_t> usable;   // per texel: whether a patch may start there
  std::vector<std::uint32_t> starts;  // the usable texels, in rising order
  PatchSpace space;
  AlignedFloats features;              // [texel][dims], of the patches at `starts`
  std::vector<std::uint32_t> similar;  // [texel][kSimilar], of the patches at `starts`
  static constexpr int kSimilar = 4;

  const float* feature(std::uint32_t start) const {
    return &features[static_cast<std::size_t>(start) * static_cast<std::size_t>(space.dims)];
  }
};

// The axes that hold `share` of the patches' variance, at most `most`, computed from at most 6,000 patches.
PatchSpace patch_space(const ExemplarLevel&, double share, int most);
// Coordinates of `count` patches that start at picture[step·i·channels], i = 0 …; rows are `pitch` floats
// apart.
void project(const PatchSpace&, const float* picture, std::size_t pitch, int step, int count, float* out);
// Fills `features`.
void measure_patches(ExemplarLevel&, const Work&);
// Fills `similar`: near patches at least 3 texels from the patch and from each other. Missing ones are
// replaced by the patch itself.
void find_similar(ExemplarLevel&, const Work&);

}  // namespace terrazzo::solids
