// A photograph's fine detail, ResidualSynth's grid, at any point of a packing.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo {

struct Volume;

class ResidualField {
 public:
  // The grid `residual` (Vec3SGrid, offsets of sRGB-encoded colours), laid so that a whole number of its
  // periods fills each edge of `box` (mm), at the scale nearest to its own: as Voxelize does. Throws Error
  // "no-residual", "bad-residual".
  ResidualField(const Volume&, const Vec3& box, const Work& = {});

  // The offset at a point, mm, within a particle or, where that is −1, within the binder; one function of
  // space for each, with the box's period. Where the tile repeats in the box every particle sees a part of
  // its own, and the binder parts that change along smooth surfaces and blend into each other with their
  // variance kept: the repetition is not to be seen.
  Vec3f at(const Vec3f& mm, int particle) const;

  Vec3 scale() const { return scale_; }  // as laid, over the residual's own
  Vec3i periods() const { return periods_; }

 private:
  Vec3f spline(const Vec3f& mm) const;
  Vec3f moved(std::uint64_t stream, std::uint64_t item) const;  // a place of the tile, mm

  Vec3i size_, periods_;
  Vec3 scale_;
  Vec3f box_, voxels_per_mm_;
  // Coefficients of a periodic cubic spline through the voxels, which keeps grain that local kernels blur.
  std::vector<std::int16_t> coefficients_;
  float unit_ = 0;
};

}  // namespace terrazzo
