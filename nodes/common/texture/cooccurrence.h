// Color co-occurrence matrices: counts of pairs of levels at given offsets (Malzbender and Spach 1993,
// section 2).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/texture/level_field.h"
#include "runtime/work.h"

namespace terrazzo {

// Offsets of up to ±extent pixels in x and y, and for scales s = 1 … scales − 1 the same times 2^s, without
// duplicates. Δ and −Δ carry the same information, so only one of them is included.
std::vector<Vec3i> cooccurrence_offsets(int extent, int scales = 1);

// Maps an offset in an image to the plane perpendicular to axis 0, 1 or 2 of a solid: columns and rows become
// y and z, x and z, or x and y. Rows further down in the image have a smaller z in planes perpendicular to x
// and y, and a smaller y perpendicular to z.
Vec3i offset_across(int axis, const Vec3i& in_picture);

struct Cooccurrence {
  int levels = 0;
  std::vector<Vec3i> offsets;
  std::vector<std::int32_t> counts;  // [offset][home level][remote level]
  std::vector<std::int64_t> pairs;   // per offset: the sum of its counts, the paper's K

  std::size_t at(std::size_t offset, int home, int remote) const {
    return (offset * static_cast<std::size_t>(levels) + static_cast<std::size_t>(home)) *
               static_cast<std::size_t>(levels) +
           static_cast<std::size_t>(remote);
  }
};

// Counts pairs of pixels that both have a level. `periodic` includes pairs across the edges.
Cooccurrence measure_cooccurrence(const LevelField&, int levels, const std::vector<Vec3i>& offsets,
                                  bool periodic, const Work& = {});

// The sum over several sections, each counted separately.
Cooccurrence measure_cooccurrence(const std::vector<LevelField>&, int levels,
                                  const std::vector<Vec3i>& offsets, const Work& = {});

// The counts scaled to a field with `pairs` pairs per offset, rounded so that their sum is exactly `pairs`.
// Throws Error "no-pairs" if the source has no pairs at that offset.
std::vector<std::int32_t> scaled_counts(const Cooccurrence&, std::size_t offset, std::int64_t pairs);

// Σ over offsets and pairs of levels of (p − q)², where p and q are probabilities. Covers half of the
// offsets: half of the paper's E without the terms of Δ = 0.
double cooccurrence_error(const Cooccurrence&, const Cooccurrence&);

}  // namespace terrazzo
