#include "nodes/detail/residual_synth/radial.h"

#include <array>
#include <cmath>
#include <numbers>

#include "nodes/common/texture/lane_fft.h"
#include "nodes/common/texture/steerable_pyramid.h"
#include "runtime/random.h"

namespace terrazzo::residual_synth {
namespace {

using Field = std::vector<LaneComplex>;  // one color axis per lane, x fastest

class Fft3 {
 public:
  explicit Fft3(const Vec3i& size)
      : size_(size), plane_(size.x(), size.y()), depth_(size.z()), each_(plane_.count()) {}
  std::size_t count() const { return each_ * size_.z(); }

  // Transforms in place. A forward and an inverse transform together multiply by count().
  void run(Field& f, bool inverse, const Work& work) const {
    work.parallel(size_.z(), 1, [&](std::size_t begin, std::size_t end) {
      std::vector<LaneComplex> scratch;
      for (std::size_t z = begin; z < end; ++z) plane_.run(&f[z * each_], inverse, scratch);
    });
    work.parallel(size_.y(), 1, [&](std::size_t begin, std::size_t end) {
      const std::size_t w = size_.x(), d = size_.z();
      std::vector<LaneComplex> lines(w * d), scratch(w * d);
      for (std::size_t y = begin; y < end; ++y) {
        for (std::size_t z = 0; z < d; ++z) std::copy_n(&f[z * each_ + y * w], w, &lines[z * w]);
        depth_.run(lines.data(), scratch.data(), size_.x(), inverse);
        for (std::size_t z = 0; z < d; ++z) std::copy_n(&lines[z * w], w, &f[z * each_ + y * w]);
      }
    });
  }

 private:
  Vec3i size_;
  LaneFft2 plane_;
  LaneFft depth_;
  std::size_t each_;
};

template <class Use>
void each_frequency(const Vec3i& size, const Work& work, Use&& use) {
  const auto angle = [](int i, int n) { return 2 * std::numbers::pi * (2 * i < n ? i : i - n) / n; };
  work.parallel(size.z(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z)
      for (int y = 0; y < size.y(); ++y)
        for (int x = 0; x < size.x(); ++x)
          use((z * static_cast<std::size_t>(size.y()) + static_cast<std::size_t>(y)) *
                      static_cast<std::size_t>(size.x()) +
                  x,
              std::hypot(angle(x, size.x()), angle(y, size.y()), angle(static_cast<int>(z), size.z())));
  });
}

// Matches each lane's real parts to the target's values.
void match_lanes(Field& f, const std::vector<const Quantiles*>& target, const Work& work) {
  std::vector<float> values(f.size());
  for (std::size_t c = 0; c < target.size(); ++c) {
    for (std::size_t i = 0; i < f.size(); ++i) values[i] = f[i].re[c];
    match_values(values, *target[c], work);
    for (std::size_t i = 0; i < f.size(); ++i) f[i].re[c] = values[i];
  }
  for (auto& v : f) v.im = Lane{};
}

}  // namespace

std::vector<Vec3f> synthesize_radial(const Exemplar& exemplar, const Vec3i& size, int rounds,
                                     std::uint64_t seed, const Work& work) {
  const Fft3 fft(size);
  const std::size_t n = fft.count();
  std::vector<Vec3f> out(n, Vec3f::Zero());
  if (exemplar.channels == 0) return out;
  const Work quiet = work.part(0, 0);
  const std::size_t channels = exemplar.channels;
  std::vector<const Quantiles*> values;
  for (std::size_t c = 0; c < channels; ++c) values.push_back(&exemplar.values[c]);

  Field volume(n), spectrum(n), band(n);
  quiet.parallel(n, 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Random random(seed, 0x3d, i);
      for (int c = 0; c < 3; ++c) volume[i].re[c] = random.normal();
    }
  });
  match_lanes(volume, values, quiet);
  const float norm = 1 / static_cast<float>(n);
  for (int round = 0; round < rounds; ++round) {
    spectrum = volume;
    fft.run(spectrum, false, quiet);
    for (auto& v : volume) v.re = v.im = Lane{};
    // The frame is tight: Σ gain² = 1, so a band's changes go back through the same gain.
    for (int scale = 0; scale <= exemplar.scales + 1; ++scale) {
      each_frequency(size, quiet, [&](std::size_t i, double r) {
        const float g = static_cast<float>(radial_gain(scale, exemplar.scales, r)) * norm;
        band[i].re = spectrum[i].re * g;
        band[i].im = spectrum[i].im * g;
      });
      fft.run(band, true, quiet);
      std::vector<const Quantiles*> target;
      for (std::size_t c = 0; c < channels; ++c) target.push_back(&exemplar.bands[0][c][scale]);
      match_lanes(band, target, quiet);
      fft.run(band, false, quiet);
      each_frequency(size, quiet, [&](std::size_t i, double r) {
        const float g = static_cast<float>(radial_gain(scale, exemplar.scales, r)) * norm;
        volume[i].re += band[i].re * g;
        volume[i].im += band[i].im * g;
      });
      work.progress((round + (scale + 1.0) / (exemplar.scales + 2)) / rounds);
    }
    fft.run(volume, true, quiet);
    match_lanes(volume, values, quiet);
  }
  for (std::size_t c = 0; c < channels; ++c) {
    double mean = 0;
    for (const auto& v : volume) mean += v.re[c];
    mean /= n;
    const Vec3f axis = exemplar.axes.col(c).cast<float>();
    for (std::size_t i = 0; i < n; ++i) out[i] += (volume[i].re[c] - static_cast<float>(mean)) * axis;
  }
  return out;
}

}  // namespace terrazzo::residual_synth
