// A volume as a stack of slices perpendicular to one axis. Slices are Fourier transformed in their plane,
// eight at a time.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <vector>

#include "nodes/common/texture/quantiles.h"
#include "nodes/common/texture/steerable_pyramid.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo {

class SliceFamily {
 public:
  // Buffers reused between calls, since allocation costs as much as the transforms.
  struct Workspace {
    std::vector<LaneComplex> spectra;              // of all groups of eight slices, in sequence
    std::vector<std::vector<LaneComplex>> coarse;  // the same for each band on a smaller grid than the slices
    struct Group {
      std::vector<LaneComplex> output, band, scratch;
    };
    tbb::enumerable_thread_specific<Group> group;  // buffers of one thread for one group
  };

  // Slices perpendicular to `axis`, with columns and rows as in slice_axes.h. Volumes are stored x fastest.
  SliceFamily(const Vec3i& size, int axis, int scales);

  // Matches the histogram of every band, over all slices, to its target and adds share · (the recombined
  // slices) to `sum`. Scales above `last_scale` remain unchanged. Changes of coarse bands are smoothed across
  // the slices according to the band's scale: independent changes would show as streaks in the other slice
  // directions.
  void match(const std::vector<float>& volume, const std::vector<Quantiles>& bands, float share,
             std::vector<float>& sum, Workspace&, const Work&, int last_scale = 1 << 20) const;
  // Filters all slices with zero phase, so that every band's standard deviation becomes its target's times
  // its entry in `aim`.
  void balance(std::vector<float>& volume, const std::vector<Quantiles>& bands,
               const std::vector<double>& aim, Workspace&, const Work&) const;
  // Multiplies each frequency of all slices by √(Σ_band factor · |transfer|²).
  void filter(std::vector<float>& volume, const std::vector<double>& factor, Workspace&, const Work&) const;
  // Standard deviation of each band over all slices / that of its target; 1 if the target's is 0.
  std::vector<double> deviations(const std::vector<float>& volume, const std::vector<Quantiles>& bands,
                                 Workspace&, const Work&) const;
  const std::vector<Band>& bands() const { return bands_; }

 private:
  static constexpr int kAtOnce = 8;  // four lanes, real and imaginary parts
  // Number of slices in a group. The last group is padded with the first slices, whose results are dropped.
  int slices_in(std::size_t group) const {
    return std::min(kAtOnce, slices_ - static_cast<int>(group) * kAtOnce);
  }
  void transform(const std::vector<float>& volume, Workspace&, const Work&) const;
  // Whether a band is on a smaller grid than the slices.
  bool is_coarse(std::size_t band) const { return crops_[band].count() < fft_.count(); }
  // The current values of each band in each group; for bands at full resolution on a part of the slices only.
  // Keeps the coarse bands.
  std::vector<std::vector<Remap::Counts>> count_values(const std::vector<Remap>&, int last_scale, Workspace&,
                                                       const Work&) const;
  // Adds norm · (the slices of a group, of the remapped bands and the rest) to `sum`.
  void recombine(std::size_t group, const std::vector<Remap>&, const std::vector<float>& rest, int last_scale,
                 float norm, std::vector<float>& sum, Workspace&) const;
  void change_coarse(const Band&, const Remap&, std::vector<LaneComplex>& values, const Work&) const;
  std::vector<double> power_of(const Workspace&, const Work&) const;
  std::vector<double> variances(const std::vector<double>& power) const;  // of each band
  // √(Σ factor · |transfer|²) at each frequency.
  std::vector<float> gain_of(const std::vector<double>& factor) const;
  void filter_spectra(std::vector<float>& volume, const std::vector<float>& gain, Workspace&,
                      const Work&) const;
  // In memory order of the volume.
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
