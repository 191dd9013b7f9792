// A volume seen as the stack of slices across one axis, each transformed in its plane: eight at a time.
#pragma once

#include <algorithm>
#include <vector>

#include "nodes/common/linear.h"
#include "nodes/common/quantiles.h"
#include "nodes/common/steerable_pyramid.h"
#include "runtime/work.h"

namespace terrazzo {

class SliceFamily {
 public:
  // Large arrays, kept between calls: fresh memory costs as much as the transforms.
  struct Workspace {
    std::vector<LaneComplex> input, output, band;  // of all groups of eight slices, one after the other
  };

  // Slices across `axis`, with columns and rows as in slice_axes.h.
  SliceFamily(const Vec3i& size, int axis, int scales);

  // Gives every band of all slices together its target distribution, and adds share · (the slices put
  // together again) to `sum`. Volumes are x fastest. Of scales beyond `last_scale` nothing is changed.
  // `drive`, a factor per band or empty, is first moved by how much too weak the band came out of the round
  // before, then multiplies its target: over rounds, what averaging and matching voxels take away is made
  // good. Returns how far from 1 a band's standard deviation in `volume` over its target's lies at most, from
  // the second round with drive on; 1 before.
  double match(const std::vector<float>& volume, const std::vector<Quantiles>& bands, float share,
               std::vector<float>& sum, Workspace&, const Work&, int last_scale = 1 << 20,
               std::vector<float>* drive = nullptr) const;
  // Standard deviation of each band over all slices / its target's; 1 where that is 0.
  std::vector<double> deviations(const std::vector<float>& volume, const std::vector<Quantiles>& bands,
                                 Workspace&, const Work&) const;
  const std::vector<Band>& bands() const { return bands_; }

 private:
  static constexpr int kAtOnce = 8;  // four lanes, real and imaginary parts
  // The slices of a group: beyond the last slice of the volume the first ones fill up, and what becomes of
  // them is dropped.
  int slices_in(std::size_t group) const {
    return std::min(kAtOnce, slices_ - static_cast<int>(group) * kAtOnce);
  }
  void transform(const std::vector<float>& volume, Workspace&, const Work&) const;
  // In the order in which the volume lies in memory.
  template <class Use>
  void each_pixel(Use&& use) const {
    if (step_v_ < step_u_) {
      for (int u = 0; u < fft_.width(); ++u)
        for (int v = 0; v < fft_.height(); ++v) use(u, v);
    } else {
      for (int v = 0; v < fft_.height(); ++v)
        for (int u = 0; u < fft_.width(); ++u) use(u, v);
    }
  }

  int groups_, slices_;
  LaneFft2 fft_;
  std::vector<Band> bands_;
  std::vector<LaneFft2> crops_;
  std::size_t step_u_, step_v_, step_slice_;
};

}  // namespace terrazzo
