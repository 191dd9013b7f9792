// The best match for a patch among exemplar patches tried one after the other.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "nodes/solids/synthesis/exemplar/patch_space.h"
#include "nodes/solids/synthesis/exemplar/wide.h"

namespace terrazzo::solids {

// Squared distance of two points times `penalty`, or any value above `limit` if it exceeds that. Sets
// `distance` to the squared distance if it was computed in full.
TERRAZZO_INLINE float score_of(const float* a, const float* b, int dims, float penalty, float limit,
                               float& distance) {
  Eight d = *reinterpret_cast<const Eight*>(a) - *reinterpret_cast<const Eight*>(b);
  Eight sum = d * d;
  d = *reinterpret_cast<const Eight*>(a + 8) - *reinterpret_cast<const Eight*>(b + 8);
  sum += d * d;
  if (dims > 16) {
    const float part = sum_of(sum) * penalty;
    if (part > limit) return part;
    for (int k = 16; k < dims; k += 8) {
      d = *reinterpret_cast<const Eight*>(a + k) - *reinterpret_cast<const Eight*>(b + k);
      sum += d * d;
    }
  }
  distance = sum_of(sum);
  return distance * penalty;
}

// Factors that penalize a patch.
struct Penalties {
  const float* overuse;         // per texel, of the patch that starts there
  std::array<float, 5> copies;  // by the number of the four neighbors whose exemplar layout it copies

  Penalties(const float* of_texels, float copying) : overuse(of_texels) {
    for (std::size_t n = 0; n < copies.size(); ++n) copies[n] = 1 + 0.25f * copying * static_cast<float>(n);
  }
};

// The best patch so far for one query: the one with the least d² · penalty.
struct Best {
  const ExemplarLevel& e;
  const float* query;
  const Penalties& penalties;
  FourInts continued;  // the patches that would copy the four neighbors' exemplar layout
  std::uint32_t at;
  float distance = 0, score;  // squared distance; the same times the penalty

  TERRAZZO_INLINE Best(const ExemplarLevel& level, const float* of_patch, const Penalties& counted,
                       const FourInts& goes_on, std::uint32_t start)
      : e(level), query(of_patch), penalties(counted), continued(goes_on), at(start) {
    score = score_of(query, e.feature(at), e.space.dims, penalty(at), std::numeric_limits<float>::infinity(),
                     distance);
  }
  TERRAZZO_INLINE float penalty(std::uint32_t c) const {
    const auto goes_on = continued == FourInts{c, c, c, c};  // −1 where equal
    const auto pairs = goes_on + __builtin_shufflevector(goes_on, goes_on, 2, 3, 0, 1);
    return penalties.overuse[c] * penalties.copies[static_cast<std::size_t>(-(pairs[0] + pairs[1]))];
  }
  TERRAZZO_INLINE void consider(std::uint32_t c) {
    if (c == at) return;
    float d = 0;
    const float s = score_of(query, e.feature(c), e.space.dims, penalty(c), score, d);
    if (s < score) {
      at = c;
      score = s;
      distance = d;
    }
  }
  // Tries the patch (dx, dy) texels from c if there is one. The offset is less than a patch along one axis,
  // so that a step beyond a border ends where no patch can start.
  TERRAZZO_INLINE void shifted(std::uint32_t c, int dx, int dy) {
    const std::size_t s = static_cast<std::ptrdiff_t>(c) + dy * e.width + dx;
    if (s < e.usable.size() && e.usable[s]) consider(static_cast<std::uint32_t>(s));
  }
  TERRAZZO_INLINE void similar() {
    const std::uint32_t* known = &e.similar[static_cast<std::size_t>(at) * ExemplarLevel::kSimilar];
    for (int k = 0; k < ExemplarLevel::kSimilar; ++k) consider(known[k]);
  }
  // Shrinking random search: patches ever nearer to the best so far, each drawn from two numbers of `bits`
  // random bits. All are drawn before any is tried, so that their features can be prefetched.
  template <class Draw>
  TERRAZZO_INLINE void around(int bits, Draw&& draw) {
    std::uint32_t drawn[16];  // the reach falls to 2/5 each time: enough for any picture
    int n = 0;
    const int last_x = e.width - kPatch, last_y = e.height - kPatch, x0 = static_cast<int>(at) % e.width,
              y0 = static_cast<int>(at) / e.width;
    for (int reach = std::max(last_x, last_y); reach >= 2; reach = reach * 2 / 5) {
      const int lo_x = std::max(0, x0 - reach), hi_x = std::min(last_x, x0 + reach);
      const int lo_y = std::max(0, y0 - reach), hi_y = std::min(last_y, y0 + reach);
      const std::array<std::uint64_t, 2> random = draw();
      const int x =
          lo_x + static_cast<int>((random[0] * static_cast<std::uint64_t>(hi_x - lo_x + 1)) >> bits);
      const int y =
          lo_y + static_cast<int>((random[1] * static_cast<std::uint64_t>(hi_y - lo_y + 1)) >> bits);
      drawn[n] = static_cast<std::uint32_t>(y * e.width + x);
      __builtin_prefetch(e.feature(drawn[n++]));
    }
    for (int k = 0; k < n; ++k)
      if (e.usable[drawn[k]]) consider(drawn[k]);
  }
};

}  // namespace terrazzo::solids
