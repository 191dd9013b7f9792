// The weight of a match as a function of its distance.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace terrazzo::solids {

// (1 + x)^power for x ≥ 0, within 1e-5, from a table that is linear between 128 steps per octave. A shader
// can repeat the same operations and get the same bits, which library power functions do not guarantee.
class WeightTable {
 public:
  static constexpr int kOctaves = 24, kPlaces = 128, kShift = 16;

  explicit WeightTable(double power) {
    for (int i = 0; i <= kOctaves * kPlaces; ++i)
      at_.push_back(static_cast<float>(
          std::pow(std::bit_cast<float>(kOne + (static_cast<std::uint32_t>(i) << kShift)), power)));
  }
  float of(float x) const {
    const std::uint32_t bits =
        std::min(std::bit_cast<std::uint32_t>(1.0f + x) - kOne, kOctaves * kPlaces * (1u << kShift) - 1);
    const std::uint32_t i = bits >> kShift;
    const float part = static_cast<float>(bits & ((1u << kShift) - 1)) * (1.0f / (1u << kShift));
    return at_[i] + part * (at_[i + 1] - at_[i]);
  }
  const std::vector<float>& entries() const { return at_; }

 private:
  static constexpr std::uint32_t kOne = 0x3f800000u;
  std::vector<float> at_;
};

}  // namespace terrazzo::solids
