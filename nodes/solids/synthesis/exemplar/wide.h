// Vectors of floats, and the choice between builds of one loop: for processors with AVX-512, with AVX2, and
// for all others. All do the same operations in the same order, so their results have the same bits.
#pragma once

#include <cstdint>

// These vectors are only passed between inlined functions.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace terrazzo::solids {

// Unaligned on purpose: rows of patches start anywhere.
using Eight = float __attribute__((vector_size(32), aligned(4), may_alias));

using Sixteen = float __attribute__((vector_size(64), aligned(4), may_alias));

using Four = float __attribute__((vector_size(16), aligned(4), may_alias));
using FourInts = std::uint32_t __attribute__((vector_size(16), aligned(4), may_alias));

#if defined(__x86_64__)
#define TERRAZZO_AVX2 __attribute__((target("avx2")))
#define TERRAZZO_AVX512 __attribute__((target("avx512f")))
inline bool has_avx2() { return __builtin_cpu_supports("avx2"); }
inline bool has_avx512() { return __builtin_cpu_supports("avx512f"); }
#else
#define TERRAZZO_AVX2
#define TERRAZZO_AVX512
inline bool has_avx2() { return false; }
inline bool has_avx512() { return false; }
#endif
// For the loop bodies that all builds share.
#define TERRAZZO_INLINE [[gnu::always_inline]] inline

TERRAZZO_INLINE float sum_of(const Eight& v) {
  const Four fours = __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
  const Four pairs = fours + __builtin_shufflevector(fours, fours, 2, 3, 0, 1);
  return pairs[0] + pairs[1];
}

// The sum of each half's four values, in all four places of that half.
TERRAZZO_INLINE Eight half_sums(const Eight& v) {
  const Eight pairs = v + __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5);
  return pairs + __builtin_shufflevector(pairs, pairs, 1, 0, 3, 2, 5, 4, 7, 6);
}

}  // namespace terrazzo::solids
