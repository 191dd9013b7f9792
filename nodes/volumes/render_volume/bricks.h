// The scan in bricks. Each holds all voxels needed to sample inside it, and the distance from it to the
// nearest visible brick.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/volumes/render_volume/scan_field.h"
#include "nodes/volumes/render_volume/tissue.h"

namespace terrazzo::render_volume {

class Bricks {
 public:
  static constexpr int kCells = 8;  // cells per side; a cell is between eight voxel centers
  static constexpr int kSide =
      kCells + 3;  // stored voxels per side: those of the cells, and one around them for gradients
  static constexpr int kVoxels = kSide * kSide * kSide;

  // `intervals` defines the visible densities. Only visible bricks and their neighbors are stored.
  Bricks(const ScanField&, const DensityIntervals&, const Work& = {});

  // Positions count voxels; voxel 0 has its center at 1. Cells begin at 0, half a voxel before the volume,
  // since voxels beyond the border equal those at it.
  const Vec3i& count() const { return count_; }  // bricks per side
  std::size_t index(int x, int y, int z) const { return voxel_at(x, y, z, count_); }
  // 0: this brick contains visible densities. Otherwise the distance in bricks to the nearest visible one,
  // where a diagonal counts as one; at most 255.
  std::uint8_t distance(std::size_t brick) const { return distance_[brick]; }
  const std::vector<std::uint8_t>& distances() const { return distance_; }
  // Voxels of the brick, x fastest; null if neither it nor a neighbor is visible.
  const std::uint16_t* voxels(std::size_t brick) const {
    const std::int32_t at = place_[brick];
    return at < 0 ? nullptr : stored_.data() + static_cast<std::size_t>(at) * kVoxels;
  }
  double visible_share() const { return visible_share_; }  // fraction of the bricks

 private:
  Vec3i count_;
  std::vector<std::uint8_t> distance_;
  std::vector<std::int32_t> place_;
  std::vector<std::uint16_t> stored_;
  double visible_share_ = 0;
};

}  // namespace terrazzo::render_volume
