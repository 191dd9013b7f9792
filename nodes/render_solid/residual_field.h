// A photograph's fine detail (ResidualSynth's grid) at any point of a packing.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo {
struct Volume;
}

namespace terrazzo::render_solid {

class ResidualField {
 public:
  // Uses the grid `residual` (Vec3SGrid, offsets of sRGB-encoded colors), scaled so that a whole number of
  // periods fills each edge of `box` (mm), at the scale nearest to its own, as Voxelize does. Throws Error
  // "no-residual", "bad-residual".
  ResidualField(const Volume&, const Vec3& box, const Work& = {});

  // The offset at a point in mm, within a particle or, if that is −1, within the binder. Each is a function
  // of space with the box's period. If the tile repeats in the box, every particle uses its own part of the
  // tile; in the binder the part changes along smooth surfaces, and parts blend with their variance
  // preserved, so that no repetition shows.
  Vec3f at(const Vec3f& mm, int particle) const;

  Vec3 scale() const { return scale_; }  // as used, relative to the residual's own
  Vec3i periods() const { return periods_; }

 private:
  Vec3f spline(const Vec3f& mm) const;
  Vec3f moved(std::uint64_t stream, std::uint64_t item) const;  // a random place in the tile, mm

  Vec3i size_, periods_;
  Vec3 scale_;
  Vec3f box_, voxels_per_mm_;
  // Coefficients of a periodic cubic spline through the voxels, which keeps grain that local kernels blur.
  std::vector<std::int16_t> coefficients_;
  float unit_ = 0;
};

}  // namespace terrazzo::render_solid
