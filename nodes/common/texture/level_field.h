// Level fields: images and solids whose pixels are indices of a few colors.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"

namespace terrazzo {

inline constexpr int kMostLevels = 32;
inline constexpr std::uint8_t kNoLevel = 255;  // for pixels that do not take part

struct LevelField {
  Vec3i size = Vec3i::Zero();    // x fastest; an image has one layer, with rows from the top
  std::vector<std::uint8_t> at;  // 0 … levels − 1, or kNoLevel

  LevelField() = default;
  explicit LevelField(const Vec3i& size, std::uint8_t fill = 0) : size(size), at(voxels_in(size), fill) {}
  std::size_t index(int x, int y, int z = 0) const { return voxel_at(x, y, z, size); }
};

}  // namespace terrazzo
