#include "nodes/common/texture/slice_family.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

constexpr int kLanes = sizeof(LaneComplex) / sizeof(float);

float* lanes(LaneComplex& c) { return reinterpret_cast<float*>(&c); }

// Counts the band's values in a group, except for slices that only pad the group. Samples every fourth value
// of large bands.
void count_group(const Remap& remap, LaneComplex* group, std::size_t each, int used, Remap::Counts& counts) {
  const std::size_t step = each > 2048 ? 4 : 1;
  for (std::size_t i = 0; i < each; i += step) remap.count(lanes(group[i]), std::min(used, kLanes), counts);
}

}  // namespace

SliceFamily::SliceFamily(const Vec3i& size, int axis, int scales)
    : groups_((size[axis] + kAtOnce - 1) / kAtOnce),
      slices_(size[axis]),
      fft_(size[kSliceColumns[axis]], size[kSliceRows[axis]]),
      bands_(pyramid_bands(fft_.width(), fft_.height(), scales)) {
  for (const Band& b : bands_) crops_.emplace_back(b.width, b.height);
  const std::size_t steps[3] = {1, static_cast<std::size_t>(size.x()), pixels_in(size.x(), size.y())};
  step_u_ = steps[kSliceColumns[axis]];
  step_v_ = steps[kSliceRows[axis]];
  step_slice_ = steps[axis];
}

void SliceFamily::transform(const std::vector<float>& volume, Workspace& space, const Work& work) const {
  space.spectra.resize(fft_.count() * groups_);
  work.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
    auto& scratch = space.group.local().scratch;
    for (std::size_t g = begin; g < end; ++g) {
      LaneComplex* group = &space.spectra[g * fft_.count()];
      const float* from[kAtOnce];
      for (int i = 0; i < kAtOnce; ++i) from[i] = volume.data() + (g * kAtOnce + i) % slices_ * step_slice_;
      each_pixel([&](int u, int v) {
        float* to = lanes(group[pixel_at(u, v, fft_.width())]);
        for (int i = 0; i < kAtOnce; ++i) to[i] = from[i][u * step_u_ + v * step_v_];
      });
      fft_.run(group, false, scratch);
    }
  });
}

// Replaces values by their mapped values, with the change smoothed across the slices to the resolution of the
// band within them.
void SliceFamily::change_coarse(const Band& band, const Remap& remap, std::vector<LaneComplex>& values,
                                const Work& work) const {
  // Gaussian with half height at the band's upper edge.
  const double sigma = std::sqrt(2 * std::numbers::ln2) / upper_edge(band.scale);
  const int reach = round_up(2.5 * sigma);
  std::vector<float> kernel;
  float all = 0;
  for (int k = -reach; k <= reach; ++k)
    all += kernel.emplace_back(static_cast<float>(std::exp(-0.5 * k * k / (sigma * sigma))));
  for (float& k : kernel) k /= all;
  const std::size_t each = values.size() / groups_;
  const int n = slices_;
  work.parallel(each, 64, [&](std::size_t begin, std::size_t end) {
    std::vector<float> line(n), wide(n + 2 * reach);
    for (std::size_t i = begin; i < end; ++i) {
      for (int s = 0; s < n; ++s) line[s] = lanes(values[s / kAtOnce * each + i])[s % kAtOnce];
      for (int s = 0; s < n; ++s) wide[reach + s] = line[s];
      remap.apply(&wide[reach], n);
      for (int s = 0; s < n; ++s) wide[reach + s] -= line[s];
      for (int s = 0; s < reach; ++s) {
        wide[reach - 1 - s] = wide[reach + n - 1 - s % n];
        wide[reach + n + s] = wide[reach + s % n];
      }
      for (int s = 0; s < n; ++s) {
        float sum = line[s];
        for (int k = 0; k <= 2 * reach; ++k) sum += kernel[k] * wide[s + k];
        lanes(values[s / kAtOnce * each + i])[s % kAtOnce] = sum;
      }
    }
  });
}

std::vector<std::vector<Remap::Counts>> SliceFamily::count_values(const std::vector<Remap>& remap,
                                                                  int last_scale, Workspace& space,
                                                                  const Work& work) const {
  std::vector<std::vector<Remap::Counts>> counts(groups_);
  work.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
    auto& local = space.group.local();
    local.band.resize(fft_.count());
    for (std::size_t g = begin; g < end; ++g) {
      counts[g].resize(bands_.size());
      for (std::size_t b = 0; b < bands_.size(); ++b) {
        if (bands_[b].scale > last_scale || !(is_coarse(b) || groups_ < 8 || g % 4 == 1)) continue;
        LaneComplex* band = is_coarse(b) ? &space.coarse[b][g * crops_[b].count()] : local.band.data();
        extract_band(bands_[b], crops_[b], &space.spectra[g * fft_.count()], fft_.count(), band,
                     local.scratch);
        counts[g][b].assign(Remap::kBins, 0);
        count_group(remap[b], band, crops_[b].count(), slices_in(g), counts[g][b]);
      }
    }
  });
  return counts;
}

void SliceFamily::recombine(std::size_t group, const std::vector<Remap>& remap,
                            const std::vector<float>& rest, int last_scale, float norm,
                            std::vector<float>& sum, Workspace& space) const {
  auto& local = space.group.local();
  local.band.resize(fft_.count());
  local.output.resize(fft_.count());
  const LaneComplex* in = &space.spectra[group * fft_.count()];
  LaneComplex* output = local.output.data();
  for (std::size_t i = 0; i < fft_.count(); ++i) {
    output[i].re = in[i].re * rest[i];
    output[i].im = in[i].im * rest[i];
  }
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    if (bands_[b].scale > last_scale) continue;
    LaneComplex* band = local.band.data();
    if (is_coarse(b)) {
      band = &space.coarse[b][group * crops_[b].count()];
    } else {
      extract_band(bands_[b], crops_[b], in, fft_.count(), band, local.scratch);
      remap[b].apply(lanes(*band), crops_[b].count() * kAtOnce);
    }
    add_band(bands_[b], crops_[b], band, fft_.count(), output, local.scratch);
  }
  fft_.run(output, true, local.scratch);
  const int used = slices_in(group);
  float* to = sum.data() + group * kAtOnce * step_slice_;
  each_pixel([&](int u, int v) {
    const float* from = lanes(output[pixel_at(u, v, fft_.width())]);
    float* voxel = to + u * step_u_ + v * step_v_;
    for (int i = 0; i < used; ++i) voxel[i * step_slice_] += norm * from[i];
  });
}

void SliceFamily::match(const std::vector<float>& volume, const std::vector<Quantiles>& bands, float share,
                        std::vector<float>& sum, Workspace& space, const Work& work, int last_scale) const {
  const Work quiet = work.quiet();
  transform(volume, space, quiet);
  // The share of each coefficient in the unchanged bands: Σ gain², since the frame is tight.
  std::vector<float> rest(fft_.count(), 0.0f);
  std::vector<Remap> remap;
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    remap.emplace_back(bands[b]);
    if (bands_[b].scale > last_scale)
      for (std::size_t i = 0; i < bands_[b].gain.size(); ++i)
        if (bands_[b].gain[i] != 0) rest[bands_[b].source[i]] += bands_[b].gain[i] * bands_[b].gain[i];
  }
  // Count the current values first. Then all bands of a group can be recombined while the group is in the
  // cache.
  space.coarse.resize(bands_.size());
  for (std::size_t b = 0; b < bands_.size(); ++b)
    if (is_coarse(b) && bands_[b].scale <= last_scale) space.coarse[b].resize(crops_[b].count() * groups_);
  const auto counts = count_values(remap, last_scale, space, work.part(0, 0.2));
  quiet.parallel(bands_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      if (bands_[b].scale > last_scale) continue;
      Remap::Counts all(Remap::kBins, 0);
      for (const auto& c : counts)
        for (std::size_t i = 0; i < c[b].size(); ++i) all[i] += c[b][i];
      remap[b].finish(all);
    }
  });
  for (std::size_t b = 0; b < bands_.size(); ++b)
    if (is_coarse(b) && bands_[b].scale <= last_scale)
      change_coarse(bands_[b], remap[b], space.coarse[b], quiet);
  const float norm = share / fft_.count();
  work.part(0.2, 1).parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g) recombine(g, remap, rest, last_scale, norm, sum, space);
  });
}

// The power of all slices at each frequency.
std::vector<double> SliceFamily::power_of(const Workspace& space, const Work& work) const {
  std::vector<double> power(fft_.count());
  work.parallel(fft_.count(), 4096, [&](std::size_t begin, std::size_t end) {
    for (int g = 0; g < groups_; ++g) {
      const LaneComplex* in = &space.spectra[g * fft_.count()];
      const int used = slices_in(g);
      for (std::size_t i = begin; i < end; ++i) {
        if (used == kAtOnce) {
          const Lane square = in[i].re * in[i].re + in[i].im * in[i].im;
          power[i] += square[0] + square[1] + square[2] + square[3];
          continue;
        }
        // A lane holds two slices as real and imaginary part; the mirrored coefficient separates them.
        const std::size_t w = fft_.width(), h = fft_.height();
        const LaneComplex& mirror = in[(h - i / w) % h * w + (w - i % w) % w];
        for (int l = 0; l < used; ++l) {
          const int k = l % 4;
          const float re = l < 4 ? in[i].re[k] + mirror.re[k] : in[i].im[k] + mirror.im[k],
                      im = l < 4 ? in[i].im[k] - mirror.im[k] : mirror.re[k] - in[i].re[k];
          power[i] += (re * re + im * im) / 4;
        }
      }
    }
  });
  // Subtract the volume's mean, which is not a deviation.
  double mean = 0;
  for (int g = 0; g < groups_; ++g)
    for (int l = 0; l < slices_in(g); ++l) {
      const LaneComplex& c = space.spectra[g * fft_.count()];
      mean += l < 4 ? c.re[l % 4] : c.im[l % 4];
    }
  power[0] = std::max(0.0, power[0] - mean * mean / slices_);
  const double n = fft_.count();
  for (double& p : power) p /= n * n * slices_;
  return power;
}

// By Parseval's identity, without computing the bands.
std::vector<double> SliceFamily::variances(const std::vector<double>& power) const {
  std::vector<double> out(bands_.size(), 0.0);
  for (std::size_t b = 0; b < bands_.size(); ++b)
    for (std::size_t i = 0; i < bands_[b].gain.size(); ++i)
      out[b] += static_cast<double>(bands_[b].gain[i]) * bands_[b].gain[i] * power[bands_[b].source[i]];
  return out;
}

std::vector<double> SliceFamily::deviations(const std::vector<float>& volume,
                                            const std::vector<Quantiles>& bands, Workspace& space,
                                            const Work& work) const {
  transform(volume, space, work.quiet());
  std::vector<double> out;
  for (const double v : variances(power_of(space, work.quiet())))
    out.push_back(bands[out.size()].deviation > 0 ? std::sqrt(v) / bands[out.size()].deviation : 1);
  return out;
}

std::vector<float> SliceFamily::gain_of(const std::vector<double>& factor) const {
  std::vector<float> gain(fft_.count(), 0.0f);
  for (std::size_t b = 0; b < bands_.size(); ++b)
    for (std::size_t i = 0; i < bands_[b].gain.size(); ++i)
      if (bands_[b].gain[i] != 0)
        gain[bands_[b].source[i]] += static_cast<float>(factor[b]) * bands_[b].gain[i] * bands_[b].gain[i];
  for (float& g : gain) g = std::sqrt(g);
  return gain;
}

void SliceFamily::filter_spectra(std::vector<float>& volume, const std::vector<float>& gain, Workspace& space,
                                 const Work& work) const {
  work.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
    auto& scratch = space.group.local().scratch;
    for (std::size_t g = begin; g < end; ++g) {
      LaneComplex* group = &space.spectra[g * fft_.count()];
      for (std::size_t i = 0; i < fft_.count(); ++i) {
        const float f = gain[i] / fft_.count();
        group[i].re *= f;
        group[i].im *= f;
      }
      fft_.run(group, true, scratch);
      const int used = slices_in(g);
      float* to = volume.data() + g * kAtOnce * step_slice_;
      each_pixel([&](int u, int v) {
        const float* from = lanes(group[pixel_at(u, v, fft_.width())]);
        float* voxel = to + u * step_u_ + v * step_v_;
        for (int i = 0; i < used; ++i) voxel[i * step_slice_] = from[i];
      });
    }
  });
}

void SliceFamily::balance(std::vector<float>& volume, const std::vector<Quantiles>& bands,
                          const std::vector<double>& aim, Workspace& space, const Work& work) const {
  const Work quiet = work.quiet();
  transform(volume, space, quiet);
  const auto power = power_of(space, quiet);
  const std::size_t n = bands_.size();
  // Bands overlap, so a factor on one band also affects its neighbors. overlap[b·n + d] is the contribution
  // of band d's factor to the variance of band b.
  std::vector<double> overlap(n * n);
  quiet.parallel(n, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<double> seen(power.size());
    for (std::size_t d = begin; d < end; ++d) {
      std::fill(seen.begin(), seen.end(), 0.0);
      for (std::size_t i = 0; i < bands_[d].gain.size(); ++i)
        if (bands_[d].gain[i] != 0)
          seen[bands_[d].source[i]] =
              static_cast<double>(bands_[d].gain[i]) * bands_[d].gain[i] * power[bands_[d].source[i]];
      const auto of = variances(seen);
      for (std::size_t b = 0; b < n; ++b) overlap[b * n + d] = of[b];
    }
  });
  std::vector<double> factor(n, 1.0), move(n);
  for (int round = 0; round < 40; ++round) {
    for (std::size_t b = 0; b < n; ++b) {
      double now = 0;
      for (std::size_t d = 0; d < n; ++d) now += overlap[b * n + d] * factor[d];
      const double wanted = bands[b].deviation * aim[b];
      move[b] = wanted > 0 && now > 0 ? wanted * wanted / now : 1;
    }
    for (std::size_t b = 0; b < n; ++b) factor[b] = std::clamp(factor[b] * move[b], 1.0 / 16, 16.0);
  }
  filter_spectra(volume, gain_of(factor), space, quiet);
}

void SliceFamily::filter(std::vector<float>& volume, const std::vector<double>& factor, Workspace& space,
                         const Work& work) const {
  transform(volume, space, work.quiet());
  filter_spectra(volume, gain_of(factor), space, work.quiet());
}

}  // namespace terrazzo
