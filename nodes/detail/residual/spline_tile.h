// A tile of color offsets that can be read anywhere between its voxels.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::residual {

// What a spline keeps.
enum class Keep {
  Values,  // passes through the voxels; between them, white noise has 2/3 of its variance
  Power  // mean power of any frequency over all places between the voxels, for planes that cut them anywhere
};

class SplineTile {
 public:
  SplineTile() = default;
  // `values`: one period, x fastest; size.prod() of them. Coefficients of a periodic cubic spline are kept in
  // 16 bits: the one through the voxels (Unser 1999), or with the voxels as coefficients of orthonormal
  // splines (Battle 1987, Lemarié 1988), whose power is theirs.
  SplineTile(std::vector<Vec3f> values, const Vec3i& size, Keep = Keep::Values, const Work& = {});

  // The offset at `p`, in voxels: voxel (i, j, k) has its center at (i, j, k). The tile repeats.
  Vec3f at(const Vec3f& p) const;
  const Vec3i& size() const { return size_; }

 private:
  Vec3i size_ = Vec3i::Zero();
  std::vector<std::int16_t> coefficients_;
  float unit_ = 0;
};

// Smooths one period for voxels that are `footprint` times as long, at least 1, and restores the deviation
// that its slices would have if only they were smoothed. A plane smooths in two directions, a solid in three,
// so without this the coarse solid's sections would have less contrast than the reduced photograph.
void widen_footprint(std::vector<Vec3f>& values, const Vec3i& size, double footprint, const Work& = {});

}  // namespace terrazzo::residual
