// The scan in blocks that each hold all that a sample within needs, and how far it is from anywhere to
// something that can be seen.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/render_volume/scan_field.h"
#include "nodes/render_volume/tissue.h"

namespace terrazzo::render_volume {

class Bricks {
 public:
  static constexpr int kCells = 8;  // cells a side; a cell lies between eight voxel centres
  static constexpr int kSide =
      kCells + 3;  // stored voxels a side: those of the cells, and one around for gradients
  static constexpr int kVoxels = kSide * kSide * kSide;

  // `intervals` tells which densities can be seen. Bricks that can be, and their neighbours, are stored.
  Bricks(const ScanField&, const DensityIntervals&, const Work& = {});

  // Positions count voxels, voxel 0 being centred at 1: cells begin at 0, half a voxel before the volume
  // does, since voxels beyond the border equal those at it.
  const Vec3i& count() const { return count_; }  // bricks a side
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * count_.y() + y) * count_.x() + x;
  }
  // 0: this brick holds something that can be seen. Else no brick does that is fewer bricks away, diagonals
  // counting as one; at most 255.
  std::uint8_t distance(std::size_t brick) const { return distance_[brick]; }
  const std::vector<std::uint8_t>& distances() const { return distance_; }
  // Its voxels, x fastest; null where neither it nor a neighbour can be seen.
  const std::uint16_t* voxels(std::size_t brick) const {
    const std::int32_t at = place_[brick];
    return at < 0 ? nullptr : stored_.data() + static_cast<std::size_t>(at) * kVoxels;
  }
  double visible_share() const { return visible_share_; }  // of the bricks

 private:
  Vec3i count_;
  std::vector<std::uint8_t> distance_;
  std::vector<std::int32_t> place_;
  std::vector<std::uint16_t> stored_;
  double visible_share_ = 0;
};

}  // namespace terrazzo::render_volume
