#include "nodes/common/slice_family.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/slice_axes.h"

namespace terrazzo {
namespace {

constexpr int kLanes = sizeof(LaneComplex) / sizeof(float);

float* lanes(LaneComplex& c) { return reinterpret_cast<float*>(&c); }

// Of the band's values in the group: what they hold about all slices' standard deviation.
struct Moments {
  double n = 0, first = 0, second = 0;
  double deviation() const {
    const double mean = n > 0 ? first / n : 0;
    return n > 0 ? std::sqrt(std::max(0.0, second / n - mean * mean)) : 0;
  }
  void add(const Moments& m) { n += m.n, first += m.first, second += m.second; }
};

Moments moments_of(LaneComplex* group, std::size_t each, int used) {
  Moments m;
  for (std::size_t i = 0; i < each; ++i)
    for (int l = 0; l < used; ++l) {
      const double v = lanes(group[i])[l];
      m.first += v, m.second += v * v;
    }
  m.n = static_cast<double>(each) * used;
  return m;
}

// The band's values in the group, but for those of slices that only fill it up. Large bands are told by a
// quarter of their values.
void count_group(const Remap& remap, LaneComplex* group, std::size_t each, int used, Remap::Counts& counts) {
  const std::size_t step = each > 2048 ? 4 : 1;
  for (std::size_t i = 0; i < each; i += step)
    remap.count(lanes(group[i]), static_cast<std::size_t>(std::min(used, kLanes)), counts);
}

}  // namespace

SliceFamily::SliceFamily(const Vec3i& size, int axis, int scales)
    : groups_((size[axis] + kAtOnce - 1) / kAtOnce),
      slices_(size[axis]),
      fft_(size[kSliceColumns[axis]], size[kSliceRows[axis]]),
      bands_(pyramid_bands(fft_.width(), fft_.height(), scales)) {
  for (const Band& b : bands_) crops_.emplace_back(b.width, b.height);
  const std::size_t steps[3] = {1, static_cast<std::size_t>(size.x()),
                                static_cast<std::size_t>(size.x()) * size.y()};
  step_u_ = steps[kSliceColumns[axis]], step_v_ = steps[kSliceRows[axis]], step_slice_ = steps[axis];
}

void SliceFamily::transform(const std::vector<float>& volume, Workspace& space, const Work& work) const {
  space.input.resize(fft_.count() * groups_);
  work.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch;
    for (std::size_t g = begin; g < end; ++g) {
      LaneComplex* group = &space.input[g * fft_.count()];
      const float* from[kAtOnce];
      for (int i = 0; i < kAtOnce; ++i)
        from[i] = volume.data() + (g * kAtOnce + i) % static_cast<std::size_t>(slices_) * step_slice_;
      each_pixel([&](int u, int v) {
        float* to = lanes(group[static_cast<std::size_t>(v) * fft_.width() + u]);
        for (int i = 0; i < kAtOnce; ++i) to[i] = from[i][u * step_u_ + v * step_v_];
      });
      fft_.run(group, false, scratch);
    }
  });
}

double SliceFamily::match(const std::vector<float>& volume, const std::vector<Quantiles>& bands, float share,
                          std::vector<float>& sum, Workspace& space, const Work& work, int last_scale,
                          std::vector<float>* drive) const {
  const bool first = drive && drive->empty();  // nothing is known yet of what gets lost
  if (first) drive->assign(bands_.size(), 1.0f);
  double furthest = drive && !first ? 0 : 1;
  const Work quiet = work.part(0, 0);
  transform(volume, space, quiet);
  space.output.resize(space.input.size());
  // What the bands left alone hold of each coefficient: the frame is tight.
  std::vector<float> rest(fft_.count(), 0.0f);
  for (const Band& b : bands_)
    if (b.scale > last_scale)
      for (std::size_t i = 0; i < b.gain.size(); ++i)
        if (b.gain[i] != 0) rest[b.source[i]] += b.gain[i] * b.gain[i];
  quiet.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t g = begin; g < end; ++g)
      for (std::size_t i = 0; i < fft_.count(); ++i) {
        const LaneComplex& in = space.input[g * fft_.count() + i];
        space.output[g * fft_.count() + i] = {in.re * rest[i], in.im * rest[i]};
      }
  });
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    if (bands_[b].scale > last_scale) continue;
    const std::size_t each = crops_[b].count();
    space.band.resize(std::max(space.band.size(), each * groups_));
    Remap remap(bands[b]);
    std::vector<Remap::Counts> counts(groups_);
    std::vector<Moments> moments(groups_);
    quiet.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
      std::vector<LaneComplex> scratch;
      for (std::size_t g = begin; g < end; ++g) {
        LaneComplex* group = &space.band[g * each];
        extract_band(bands_[b], crops_[b], &space.input[g * fft_.count()], fft_.count(), group, scratch);
        counts[g].assign(Remap::kBins, 0);
        count_group(remap, group, each, slices_in(g), counts[g]);
        if (drive && !first) moments[g] = moments_of(group, each, std::min(slices_in(g), kLanes));
      }
    });
    for (int g = 1; g < groups_; ++g)
      for (int i = 0; i < Remap::kBins; ++i) counts[0][i] += counts[g][i];
    remap.finish(counts[0]);
    float gain = 1;
    if (drive && !first) {
      for (int g = 1; g < groups_; ++g) moments[0].add(moments[g]);
      const double now = moments[0].deviation();
      if (bands[b].deviation > 0) furthest = std::max(furthest, std::abs(now / bands[b].deviation - 1));
      float& d = (*drive)[b];
      if (now > 0 && bands[b].deviation > 0)
        d = std::clamp(d * static_cast<float>(bands[b].deviation / now), 0.25f, 4.0f);
      gain = d;
    }
    quiet.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
      std::vector<LaneComplex> scratch;
      for (std::size_t g = begin; g < end; ++g) {
        LaneComplex* group = &space.band[g * each];
        LaneComplex* output = &space.output[g * fft_.count()];
        remap.apply(lanes(group[0]), each * kAtOnce);
        if (gain != 1)
          for (std::size_t i = 0; i < each * kAtOnce; ++i) lanes(group[0])[i] *= gain;
        add_band(bands_[b], crops_[b], group, fft_.count(), output, scratch);
      }
    });
    work.progress(static_cast<double>(b + 1) / static_cast<double>(bands_.size()));
  }
  const float norm = share / static_cast<float>(fft_.count());
  quiet.parallel(groups_, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch;
    for (std::size_t g = begin; g < end; ++g) {
      LaneComplex* group = &space.output[g * fft_.count()];
      fft_.run(group, true, scratch);
      const int used = slices_in(g);
      float* to = sum.data() + g * kAtOnce * step_slice_;
      each_pixel([&](int u, int v) {
        const float* from = lanes(group[static_cast<std::size_t>(v) * fft_.width() + u]);
        float* voxel = to + u * step_u_ + v * step_v_;
        for (int i = 0; i < used; ++i) voxel[i * step_slice_] += norm * from[i];
      });
    }
  });
  return furthest;
}

std::vector<double> SliceFamily::deviations(const std::vector<float>& volume,
                                            const std::vector<Quantiles>& bands, Workspace& space,
                                            const Work& work) const {
  const Work quiet = work.part(0, 0);
  transform(volume, space, quiet);
  std::vector<double> out;
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    const std::size_t each = crops_[b].count();
    const Moments all = quiet.reduce<Moments>(
        groups_, 1, {},
        [&](std::size_t begin, std::size_t end) {
          Moments m;
          std::vector<LaneComplex> scratch, band(each);
          for (std::size_t g = begin; g < end; ++g) {
            extract_band(bands_[b], crops_[b], &space.input[g * fft_.count()], fft_.count(), band.data(),
                         scratch);
            m.add(moments_of(band.data(), each, slices_in(g)));
          }
          return m;
        },
        [](Moments a, const Moments& b) {
          a.add(b);
          return a;
        });
    out.push_back(bands[b].deviation > 0 ? all.deviation() / bands[b].deviation : 1);
  }
  return out;
}

}  // namespace terrazzo
