// Which voxels of a solid that tiles are in one phase: a bit for each, so that the neighborhoods of a large
// solid stay in the cache.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

namespace terrazzo::annealing {

// Lines of voxels along one axis that repeat.
class PhaseBits {
 public:
  static constexpr int kReach = 8;  // voxels on both sides that around() shows: two of the widest spacing

  PhaseBits(int length, std::size_t lines)
      : length_(length),
        bytes_((length + 2 * kReach + 7) / 8),
        bits_(lines * bytes_ + sizeof(std::uint64_t)) {}

  void set(std::size_t line, int at, bool in) {
    for (int i = at - (kReach + length_ - 1) / length_ * length_; i < length_ + kReach; i += length_)
      if (i >= -kReach) set_bit(line, i + kReach, in);
  }
  // Bit kReach + d tells of the voxel at `at` + d.
  std::uint32_t around(std::size_t line, int at) const {
    std::uint64_t word;
    std::memcpy(&word, &bits_[line * bytes_ + at / 8u], sizeof word);
    return static_cast<std::uint32_t>(word >> at % 8u);
  }

 private:
  void set_bit(std::size_t line, int bit, bool in) {
    std::uint8_t& byte = bits_[line * bytes_ + bit / 8u];
    const auto mask = static_cast<std::uint8_t>(1 << bit % 8u);
    byte = in ? byte | mask : byte & ~mask;
  }

  int length_;
  std::size_t bytes_;  // of a line
  std::vector<std::uint8_t> bits_;
};

}  // namespace terrazzo::annealing
