// A tileable residual, resampled so that it tiles the particles' box.
#pragma once

#include <vector>

#include "nodes/data/opaque_volume.h"
#include "nodes/volumes/voxelize/lattice.h"
#include "runtime/work.h"

namespace terrazzo::voxelize {

class LatticeResidual {
 public:
  LatticeResidual() = default;  // none: zero everywhere
  // Reads the grid `residual` (Vec3SGrid, offsets of sRGB-encoded colors, one period in `resolution`). Each
  // edge of the box holds a whole number of periods, at the scale closest to the residual's own. Resamples
  // with periodic Lanczos kernels (a = 6, widened when downsampling); where voxels coincide, values are
  // copied. Throws Error "no-residual", "bad-residual".
  LatticeResidual(const Volume& residual, const Lattice& lattice, const Work& work);

  bool empty() const { return field_.empty(); }
  Vec3i periods() const { return periods_; }
  Vec3 scale() const { return scale_; }  // placed size / original size of a residual voxel, per axis
  // Adds plane k of the lattice to `colors`, x fastest.
  void add_plane(int k, Vec3f* colors) const;

 private:
  struct Taps {  // first input sample and weights of one output sample
    int first;
    std::vector<float> weight;
  };
  static std::vector<Taps> taps(int out, int in, int periods);

  Vec3i periods_ = Vec3i::Zero();
  Vec3 scale_ = Vec3::Ones();
  Lattice lattice_;
  int planes_ = 0;            // planes in field_
  std::vector<Vec3f> field_;  // resampled in x and y
  std::vector<Taps> z_;
};

}  // namespace terrazzo::voxelize
