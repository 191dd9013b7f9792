// Colour co-occurrence matrices: how often two levels lie at an offset from each other (Malzbender and Spach
// 1993, section 2).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/level_field.h"
#include "runtime/work.h"

namespace terrazzo {

// The offsets of up to ±extent pixels in x and y and, for further scales s = 1 … scales − 1, those times 2^s
// that are not among them yet. Δ and −Δ hold the same information, so one of each two is kept.
std::vector<Vec3i> cooccurrence_offsets(int extent, int scales = 1);

// In the plane across axis 0, 1 or 2 of a solid: a picture's columns and rows become y and z, x and z, or x
// and y. A row further down in the picture lies lower: at a smaller z across x and y, at a smaller y across
// z.
Vec3i offset_across(int axis, const Vec3i& in_picture);

struct Cooccurrence {
  int levels = 0;
  std::vector<Vec3i> offsets;
  std::vector<std::int32_t> counts;  // [offset][home level][remote level]
  std::vector<std::int64_t> pairs;   // of each offset: their sum, the paper's K

  std::size_t at(std::size_t offset, int home, int remote) const {
    return (offset * static_cast<std::size_t>(levels) + static_cast<std::size_t>(home)) *
               static_cast<std::size_t>(levels) +
           static_cast<std::size_t>(remote);
  }
};

// Counts the pairs of pixels that both have a level; `periodic`: also across the edges.
Cooccurrence measure_cooccurrence(const LevelField&, int levels, const std::vector<Vec3i>& offsets,
                                  bool periodic, const Work& = {});

// The same over several sections, each by itself.
Cooccurrence measure_cooccurrence(const std::vector<LevelField>&, int levels,
                                  const std::vector<Vec3i>& offsets, const Work& = {});

// The counts that a field with `pairs` pairs an offset would have: rounded so that each offset's sum is kept
// exactly. Throws Error "no-pairs" where the source has none at some offset.
std::vector<std::int32_t> scaled_counts(const Cooccurrence&, std::size_t offset, std::int64_t pairs);

// Σ over offsets and pairs of levels of (p − q)², p and q being probabilities: the paper's E over the half of
// the offsets, half of E without the entries of Δ = 0.
double cooccurrence_error(const Cooccurrence&, const Cooccurrence&);

}  // namespace terrazzo
