// Trying one exemplar patch after the other.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "nodes/solid_optimize/patch_space.h"
#include "nodes/solid_optimize/wide.h"

namespace terrazzo::solid_optimize {

// Squared distance of two points; anything above `limit` where it exceeds that.
TERRAZZO_INLINE float distance2(const float* a, const float* b, int dims, float limit) {
  Eight d = *reinterpret_cast<const Eight*>(a) - *reinterpret_cast<const Eight*>(b);
  Eight sum = d * d;
  d = *reinterpret_cast<const Eight*>(a + 8) - *reinterpret_cast<const Eight*>(b + 8);
  sum += d * d;
  if (dims > 16) {
    const float part = sum_of(sum);
    if (part > limit) return part;
    for (int k = 16; k < dims; k += 8) {
      d = *reinterpret_cast<const Eight*>(a + k) - *reinterpret_cast<const Eight*>(b + k);
      sum += d * d;
    }
  }
  return sum_of(sum);
}

// The best patch so far for one query: of least d² · penalty.
struct Best {
  const ExemplarLevel& e;
  const float *penalty, *query;
  std::uint32_t at;
  float distance, score;  // squared distance; the same times the penalty

  TERRAZZO_INLINE Best(const ExemplarLevel& level, const float* of_texels, const float* of_patch,
                       std::uint32_t start)
      : e(level), penalty(of_texels), query(of_patch), at(start) {
    distance = distance2(query, e.feature(at), e.space.dims, std::numeric_limits<float>::infinity());
    score = distance * penalty[at];
  }
  TERRAZZO_INLINE void consider(std::uint32_t c) {
    if (c == at) return;
    const float p = penalty[c];
    const float d = distance2(query, e.feature(c), e.space.dims, score / p);
    const float s = d * p;
    if (s < score) at = c, score = s, distance = d;
  }
  // The patch (dx, dy) texels from c, where there is one.
  TERRAZZO_INLINE void shifted(std::uint32_t c, int dx, int dy) {
    const int x = static_cast<int>(c) % e.width + dx, y = static_cast<int>(c) / e.width + dy;
    if (x < 0 || y < 0 || x > e.width - kPatch || y > e.height - kPatch) return;
    const auto s = static_cast<std::uint32_t>(y * e.width + x);
    if (e.usable[s]) consider(s);
  }
  TERRAZZO_INLINE void similar() {
    const std::uint32_t* known = &e.similar[static_cast<std::size_t>(at) * ExemplarLevel::kSimilar];
    for (int k = 0; k < ExemplarLevel::kSimilar; ++k) consider(known[k]);
  }
  int widest() const { return std::max(e.width, e.height) - kPatch; }
  // A patch at most `reach` texels off along both axes, drawn by two numbers of `bits` random bits.
  TERRAZZO_INLINE void within(int reach, std::uint64_t column, std::uint64_t row, int bits) {
    const int x0 = static_cast<int>(at) % e.width, y0 = static_cast<int>(at) / e.width;
    const int lo_x = std::max(0, x0 - reach), hi_x = std::min(e.width - kPatch, x0 + reach);
    const int lo_y = std::max(0, y0 - reach), hi_y = std::min(e.height - kPatch, y0 + reach);
    const int x = lo_x + static_cast<int>((column * static_cast<std::uint64_t>(hi_x - lo_x + 1)) >> bits);
    const int y = lo_y + static_cast<int>((row * static_cast<std::uint64_t>(hi_y - lo_y + 1)) >> bits);
    const auto c = static_cast<std::uint32_t>(y * e.width + x);
    if (e.usable[c]) consider(c);
  }
};

}  // namespace terrazzo::solid_optimize
