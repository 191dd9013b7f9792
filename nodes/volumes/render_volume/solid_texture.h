// A solid texture with its mip levels, and its placement at each of its three scales.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo {
struct Volume;
}

namespace terrazzo::render_volume {

struct SolidTexture {
  struct Level {
    Vec3i size;
    std::vector<std::array<std::uint16_t, 4>>
        texels;  // scene-linear / 65535 (clamped to 1), x fastest, periodic
  };
  std::vector<Level> levels;  // each half the size of the one before, down to one texel
  float texel = 1;            // mm, at level 0
  Vec3f mean = Vec3f::Zero();

  // From colors, x fastest. Throws Error "bad-colors" if one is NaN, "empty-volume".
  SolidTexture(const Vec3i& size, float texel, const std::vector<Vec3f>& colors, const Work& = {});
  // From a volume's grid `Cd`. Throws Error "no-color", "empty-volume", "bad-colors".
  static SolidTexture of(const Volume&, const Work& = {});
};

// Texture coordinates of one level at one scale: texel = linear · mm + offset.
struct Placement {
  int level = 0;
  Eigen::Matrix3f linear = Eigen::Matrix3f::Identity();
  Vec3f offset = Vec3f::Zero();
};

enum class Turning { Random, AboutZ, None };

// Placement at `scale` (1: texels have the texture's own size) for pixels that cover `footprint` mm. Rotation
// and offset are random functions of seed and `item`, so that the scales of one tissue do not line up. AboutZ
// keeps the texture's z along the scan's, for grain in that direction.
Placement placement(const SolidTexture&, double scale, double footprint, Turning, std::uint64_t seed,
                    std::uint64_t item);

}  // namespace terrazzo::render_volume
