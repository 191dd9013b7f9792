// Counter-based random numbers: Random(seed, stream, item) always produces the same sequence, independent of
// threads and order.
#pragma once

#include <cmath>
#include <cstdint>

namespace terrazzo {

// The finalizer of SplitMix64 (Steele, Lea, Flood 2014): a 64-bit bijection. Applied to a counter, it passes
// BigCrush.
constexpr std::uint64_t mix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

class Random {
 public:
  // `stream` separates different uses of a seed; `item` separates the particles, pixels or repetitions of one
  // use.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0, std::uint64_t item = 0)
      : key_(mix64(mix64(mix64(seed) ^ stream) + item * 0xd1342543de82ef95ull)) {}

  std::uint64_t bits() { return mix64(key_ + 0x9e3779b97f4a7c15ull * ++counter_); }
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }  // [0, 1)
  double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  // [0, n) for n > 0, with negligible bias for n < 2^40
  std::uint64_t below(std::uint64_t n) {
    return static_cast<std::uint64_t>((static_cast<unsigned __int128>(bits()) * n) >> 64);
  }
  double normal() {  // Box–Muller with one value of the pair, so each draw advances the counter by 2
    const double u = 1.0 - uniform(), v = uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * v);
  }
  std::uint64_t operator()() { return bits(); }  // UniformRandomBitGenerator, for std::shuffle and others
  static constexpr std::uint64_t min() { return 0; }
  static constexpr std::uint64_t max() { return ~0ull; }
  using result_type = std::uint64_t;

 private:
  std::uint64_t key_;
  std::uint64_t counter_ = 0;
};

}  // namespace terrazzo
