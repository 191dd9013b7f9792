// Low-discrepancy random numbers for one pixel: Owen-scrambled Sobol' points, with a new pair for each
// decision along a path. Burley, Practical hash-based Owen scrambling, JCGT 9(4), 2020.
#pragma once

#include <bit>
#include <cstdint>

#include "runtime/random.h"

namespace terrazzo::render_solid {

class PixelSampler {
 public:
  // `samples`: how many samples the pixel uses.
  PixelSampler(std::uint64_t seed, std::uint64_t pixel, std::uint32_t samples)
      : key_(Random(seed, 0x50697865, pixel).bits()), mask_(std::bit_ceil(samples) - 1) {}

  void start(std::uint32_t sample) {
    sample_ = reversed(sample);
    pair_ = 0;
  }

  // Two numbers in [0, 1), stratified over the pixel's samples and independent of earlier pairs.
  void next(float& u, float& v) {
    const std::uint64_t h = mix64(key_ + ++pair_);
    const auto a = static_cast<std::uint32_t>(h), b = static_cast<std::uint32_t>(h >> 32);
    // A different order of the same points, so that pairs do not align.
    const std::uint32_t i = reversed(scrambled(sample_, a ^ b)) & mask_;
    u = unit(reversed(scrambled(i, a)));
    v = unit(reversed(scrambled(reversed(second(i)), b)));
  }

 private:
  static std::uint32_t reversed(std::uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
  }
  // The second dimension of Sobol's sequence.
  static std::uint32_t second(std::uint32_t i) {
    std::uint32_t r = 0;
    for (std::uint32_t v = 1u << 31; i; i >>= 1, v ^= v >> 1)
      if (i & 1) r ^= v;
    return r;
  }
  // Laine and Karras's hash: lower bits decide whether each bit is flipped. On reversed numbers it is a
  // nested uniform permutation.
  static std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
  }
  static float unit(std::uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

  std::uint64_t key_;
  std::uint32_t mask_, sample_ = 0, pair_ = 0;
};

}  // namespace terrazzo::render_solid
