// The colours of a volume in one dense array: what a ray needs millions of times.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo {

struct Volume;

class ColorField {
 public:
  // `colors`: scene-linear, x fastest; clamped to [0, 1], as reflectance is. Throws Error "bad-colors" where
  // one is NaN.
  ColorField(Vec3i resolution, const std::vector<Vec3f>& colors, bool periodic = true);

  // Copies the grid `Cd` over one period, or over its active voxels where the volume is not periodic.
  // Throws Error "no-color" (no such grid), "empty-volume", "too-large" (more than 2^31 voxels),
  // "bad-colors".
  static ColorField of(const Volume&, const Work& = {});

  const Vec3i& resolution() const { return resolution_; }
  bool periodic() const { return periodic_; }
  float clamped() const {
    return clamped_;
  }  // share of voxels whose colour was outside [0, 1] by more than 1 %

  // Trilinear between voxel centres at i + ½; repeats, or ends with the outermost voxels where not periodic.
  Vec3f at(const Vec3f& voxel) const;
  // Catmull–Rom instead: keeps the sharpness of the voxels where a pixel is smaller than one. Within [0, 1].
  Vec3f sharp(const Vec3f& voxel) const;

 private:
  ColorField() = default;
  void set(std::size_t index, const Vec3f& linear, std::size_t& outside);
  int wrap(int i, int axis) const;
  Vec3f squared(int x, int y, int z) const {
    const auto& v = voxels_[(static_cast<std::size_t>(z) * resolution_.y() + y) * resolution_.x() + x];
    const Vec3f root(v[0], v[1], v[2]);
    return root.cwiseProduct(root);
  }

  Vec3i resolution_ = Vec3i::Zero();
  bool periodic_ = true;
  float clamped_ = 0;
  // √ of each channel in 16 bit: half the memory of floats, and finer than an eye can see in the dark.
  std::vector<std::array<std::uint16_t, 3>> voxels_;
};

}  // namespace terrazzo
