// Eight floats at a time, and the choice between two builds of one loop: for processors with AVX2 and for all
// others. Both do the same operations in the same order, so their results are the same bits.
#pragma once

#include <cstdint>

namespace terrazzo::solid_optimize {

// Unaligned on purpose: rows of patches start anywhere.
using Eight = float __attribute__((vector_size(32), aligned(4), may_alias));

using Four = float __attribute__((vector_size(16), aligned(4), may_alias));
using FourInts = std::uint32_t __attribute__((vector_size(16), aligned(4), may_alias));

#if defined(__x86_64__)
#define TERRAZZO_AVX2 __attribute__((target("avx2")))
inline bool has_avx2() { return __builtin_cpu_supports("avx2"); }
#else
#define TERRAZZO_AVX2
inline bool has_avx2() { return false; }
#endif
// What both builds of a loop are made of.
#define TERRAZZO_INLINE [[gnu::always_inline]] inline

TERRAZZO_INLINE float sum_of(const Eight& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

}  // namespace terrazzo::solid_optimize
