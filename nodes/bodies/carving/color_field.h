// The colors of a volume in one dense array, for fast random access.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo {
struct Volume;
}

namespace terrazzo::carving {

struct HiddenVoxels;

class ColorField {
 public:
  // `colors` are scene-linear, x fastest; they are clamped to [0, 1], the range of reflectance. Throws Error
  // "bad-colors" if one is NaN.
  ColorField(Vec3i resolution, const std::vector<Vec3f>& colors, bool periodic = true);

  // Copies the grid `Cd` over one period, or over its active voxels if the volume is not periodic. Without
  // it, the numbers of the grid `phase` become grays, the first one dark. Throws Error "no-color" (neither
  // grid), "empty-volume", "too-large" (more than 2^31 voxels), "bad-colors".
  static ColorField of(const Volume&, const Work& = {});

  // Gives hidden voxels close to visible ones the mean color of these, so that the colors of walls are not
  // mixed with those of what is hidden. Throws Error "size-mismatch".
  void cover(const HiddenVoxels&, const Work& = {});

  const Vec3i& resolution() const { return resolution_; }
  bool periodic() const { return periodic_; }
  double voxel() const { return voxel_; }  // mm, edge along x; 1 for colors without a grid
  float clamped() const {
    return clamped_;
  }  // fraction of voxels whose color was outside [0, 1] by more than 1 %

  // Trilinear between voxel centers at i + ½. Repeats if periodic, otherwise extends the outermost voxels.
  Vec3f at(const Vec3f& voxel) const;
  // Catmull–Rom instead, which keeps voxels sharp where pixels are smaller. Within [0, 1].
  Vec3f sharp(const Vec3f& voxel) const;

 private:
  ColorField() = default;
  template <class Grid, class ColorOf>
  void copy(const Volume&, const Grid&, const Work&, ColorOf&&);
  void set(std::size_t index, const Vec3f& linear, std::size_t& outside);
  // Sets the mean color of the voxels around `at` that are not open; false if there are none.
  bool cover_voxel(const std::vector<std::uint8_t>& open, const Vec3i& at);
  int wrap(int i, int axis) const;
  Vec3f squared(int x, int y, int z) const {
    const auto& v = voxels_[voxel_at(x, y, z, resolution_)];
    const Vec3f root(v[0], v[1], v[2]);
    return root.cwiseProduct(root);
  }

  Vec3i resolution_ = Vec3i::Zero();
  bool periodic_ = true;
  double voxel_ = 1;
  float clamped_ = 0;
  // √ of each channel in 16 bits: half the memory of floats, with steps below visibility even in the dark.
  std::vector<std::array<std::uint16_t, 3>> voxels_;
};

// Whether the volume has voids, as Voxelize makes them.
bool has_voids(const Volume&);

}  // namespace terrazzo::carving
