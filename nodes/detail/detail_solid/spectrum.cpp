#include "nodes/detail/detail_solid/spectrum.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/texture/lane_fft.h"
#include "nodes/data/indices.h"
#include "nodes/detail/detail_solid/isotropy.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kLags = 24;                            // pixels
constexpr int kWindow = 464;                         // most pixels per side that are transformed
constexpr int kFitRounds = 20;                       // of fitting the filter
constexpr double kLeastGain = 0.01, kMostGain = 16;  // of the power, relative to its mean
constexpr double kPi = std::numbers::pi;

constexpr int kSide = 2 * kLags + 1;

// One list for each of the phase's principal axes.
using Lags = std::array<std::vector<double>, 3>;

// The principal axes of a phase's offsets, in columns. In a photograph, they are about lightness and two
// chromas, whose grain differs: cameras and compression blur chroma more.
Eigen::Matrix3f axes_of(const Phases& p, int phase) {
  Mat3 covariance = Mat3::Zero();
  for (std::size_t i = 0; i < p.phase.size(); ++i) {
    if (p.phase[i] != phase) continue;
    const Vec3 d = p.offset[i].cast<double>();
    covariance += d * d.transpose();
  }
  return eigen_axes(covariance).eigenvectors().cast<float>();
}

// Covariance of pixels along each axis by lag, (2·kLags + 1)² values, relative to mean 0. Empty if there are
// too few pixels.
Lags covariance_of(const Phases& p, int phase, const Eigen::Matrix3f& axes) {
  const int w = std::min(p.width, kWindow), h = std::min(p.height, kWindow);
  const LaneFft2 fft(fast_even_size_above(w + kLags), fast_even_size_above(h + kLags));
  const std::vector<double> none(kSide * kSide, 0.0);
  Lags sum = {none, none, none};
  std::vector<double> pairs = none;
  std::vector<LaneComplex> scratch;
  // Windows in the middle of every section.
  const int x0 = (p.width - w) / 2, y0 = (p.height - h) / 2;
  const int sections = std::min(p.sections, 8);
  for (int s = 0; s < sections; ++s) {
    std::vector<LaneComplex> data(fft.count(), LaneComplex{Lane{0, 0, 0, 0}, Lane{0, 0, 0, 0}});
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const std::size_t i = s * p.plane() + pixel_at(x0, y0 + y, p.width) + x;
        if (p.phase[i] != phase) continue;
        const Vec3f v = axes.transpose() * p.offset[i];
        data[pixel_at(x, y, fft.width())].re = Lane{v.x(), v.y(), v.z(), 1};
      }
    // The transform of a real signal's power in each lane is the signal's covariance.
    fft.run(data.data(), false, scratch);
    for (LaneComplex& c : data) {
      c.re = c.re * c.re + c.im * c.im;
      c.im = Lane{0, 0, 0, 0};
    }
    fft.run(data.data(), true, scratch);
    const double scale = 1.0 / fft.count();
    for (int dy = -kLags; dy <= kLags; ++dy)
      for (int dx = -kLags; dx <= kLags; ++dx) {
        const Lane& c = data[static_cast<std::size_t>((dy + fft.height()) % fft.height()) * fft.width() +
                             (dx + fft.width()) % fft.width()]
                            .re;
        const std::size_t k = (dy + kLags) * kSide + dx + kLags;
        for (std::size_t a = 0; a < 3; ++a) sum[a][k] += scale * c[a];
        pairs[k] += scale * c[3];
      }
  }
  if (pairs[kSide * kLags + kLags] < 256) return {};
  for (std::vector<double>& s : sum)
    for (std::size_t k = 0; k < s.size(); ++k) s[k] = pairs[k] >= 64 ? s[k] / pairs[k] : 0;
  return sum;
}

// Power per frequency cell of slices of size² pixels, by radial bin |q| of the slice's frequencies. Beyond
// size/2 there are only frequencies near the diagonals.
std::vector<double> wanted_power(const std::vector<double>& covariance, int size, std::size_t bins) {
  constexpr int kDirections = 32;
  std::array<double, kSide> hann;
  for (int d = 0; d < kSide; ++d) hann[d] = 0.5 * (1 + std::cos(kPi * (d - kLags) / (kLags + 1)));
  std::vector<double> windowed = covariance;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) windowed[y * kSide + x] *= hann[x] * hann[y];
  // cos(kx·x + ky·y) = cos(kx·x) cos(ky·y) − sin(kx·x) sin(ky·y)
  std::array<double, kSide> cosine, sine;
  std::vector<double> out;
  for (std::size_t q = 0; q < bins; ++q) {
    const double k = 2 * kPi * q / size;
    double power = 0, directions = 0;
    for (int a = 0; a < kDirections; ++a) {
      const double angle = kPi * (a + 0.5) / kDirections, kx = k * std::cos(angle), ky = k * std::sin(angle);
      if (std::max(std::abs(kx), std::abs(ky)) > kPi) continue;
      ++directions;
      for (int d = 0; d < kSide; ++d) {
        cosine[d] = std::cos(kx * (d - kLags));
        sine[d] = std::sin(kx * (d - kLags));
      }
      for (int y = 0; y < kSide; ++y) {
        double even = 0, odd = 0;
        for (int x = 0; x < kSide; ++x) {
          even += windowed[y * kSide + x] * cosine[x];
          odd += windowed[y * kSide + x] * sine[x];
        }
        power += std::cos(ky * (y - kLags)) * even - std::sin(ky * (y - kLags)) * odd;
      }
    }
    out.push_back(directions > 0 ? std::max(power / directions, 0.0) : out.back());
  }
  return out;
}

// Transforms a cube along all axes.
void transform(const LaneFft& fft, std::vector<LaneComplex>& data, bool inverse, const Work& work) {
  const std::size_t n = fft.size(), plane = n * n;
  work.quiet().parallel(n, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch(plane);
    for (std::size_t z = begin; z < end; ++z) {
      for (std::size_t y = 0; y < n; ++y) fft.run(&data[z * plane + y * n], scratch.data(), 1, inverse);
      fft.run(&data[z * plane], scratch.data(), n, inverse);
    }
  });
  work.quiet().parallel(n, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> columns(plane), scratch(plane);
    for (std::size_t y = begin; y < end; ++y) {
      for (std::size_t z = 0; z < n; ++z) std::copy_n(&data[z * plane + y * n], n, &columns[z * n]);
      fft.run(columns.data(), scratch.data(), n, inverse);
      for (std::size_t z = 0; z < n; ++z) std::copy_n(&columns[z * n], n, &data[z * plane + y * n]);
    }
  });
}

}  // namespace

namespace {

// A tile's spectrum: power by radial frequency in space (ρ) and in the slices across each axis of space (q),
// since a slice adds up all frequencies along its axis.
class SlicePower {
 public:
  SlicePower(const std::vector<LaneComplex>& data, int size, std::size_t bins)
      : bins_(bins), most_(static_cast<std::size_t>(std::ceil(std::sqrt(3.0) * size / 2)) + 2) {
    const std::size_t n = size;
    const auto frequency = [&](std::size_t i) {
      return i <= n / 2 ? static_cast<double>(i) : static_cast<double>(i) - n;
    };
    for (auto& p : power_) p.assign(bins * most_, 0.0);
    distance.resize(data.size());
    std::size_t at = 0;
    for (std::size_t z = 0; z < n; ++z)
      for (std::size_t y = 0; y < n; ++y)
        for (std::size_t x = 0; x < n; ++x, ++at) {
          const Vec3 f(frequency(x), frequency(y), frequency(z));
          distance[at] = f.norm();
          const Lane p = data[at].re * data[at].re + data[at].im * data[at].im;
          const std::size_t rho = std::lround(distance[at]);
          for (int a = 0; a < 3; ++a) {
            const std::size_t q = std::lround(std::sqrt(std::max(0.0, f.squaredNorm() - f[a] * f[a])));
            if (q >= bins) continue;
            for (std::size_t c = 0; c < 3; ++c) power_[c][q * most_ + rho] += p[c];
          }
        }
    cells.assign(bins, 0.0);
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t x = 0; x < n; ++x) {
        const std::size_t q = std::lround(std::hypot(frequency(x), frequency(y)));
        if (q < bins) ++cells[q];
      }
    // Mean power of a slice's frequency cell, in the units of wanted_power: Σ_z |F|² / n · (1 / n²) per cell.
    unit_ = 1.0 / (3.0 * std::pow(static_cast<double>(n), 4));
  }

  // Power of a channel at a slice's frequency q, if that of each ρ is multiplied by a gain.
  double at(std::size_t channel, std::size_t q, const std::vector<double>& gain) const {
    double have = 0;
    for (std::size_t r = 0; r < most_; ++r) have += power_[channel][q * most_ + r] * gain[r];
    return have * unit_ / std::max(cells[q], 1.0);
  }
  std::size_t radii() const { return most_; }

  std::vector<double> distance;  // ρ of each element of the transform
  std::vector<double> cells;     // number of a slice's frequencies by q

 private:
  std::size_t bins_, most_;
  std::array<std::vector<double>, 3> power_;
  double unit_ = 1;
};

// Gains of the power by ρ that give slices the wanted power. 1 if there is nothing to gain.
std::vector<double> fitted_gains(const SlicePower& have, std::size_t channel,
                                 const std::vector<double>& wanted) {
  std::vector<double> gain(have.radii(), 1.0);
  double all = 0, given = 0;
  for (std::size_t q = 1; q < wanted.size(); ++q) {
    all += have.cells[q] * wanted[q];
    given += have.cells[q] * have.at(channel, q, gain);
  }
  if (!(all > 0) || !(given > 0)) return gain;
  const double start = all / given;
  gain.assign(have.radii(), start);
  for (int round = 0; round < kFitRounds; ++round) {
    std::vector<double> next = gain;
    for (std::size_t q = 1; q < wanted.size(); ++q)
      if (const double now = have.at(channel, q, gain); now > 0)
        next[q] = std::clamp(gain[q] * std::pow(wanted[q] / now, 0.7), kLeastGain * start, kMostGain * start);
    for (std::size_t r = wanted.size(); r < have.radii(); ++r) next[r] = next[wanted.size() - 1];
    gain = std::move(next);
  }
  return gain;
}

}  // namespace

void match_spectrum(std::vector<Vec3f>& tile, int size, const Phases& phases, int phase, const Work& work) {
  if (phases.pixels[phase] < 256) return;
  const Eigen::Matrix3f axes = axes_of(phases, phase);
  const Lags covariance = covariance_of(phases, phase, axes);
  if (covariance[0].empty()) return;
  const auto bins = static_cast<std::size_t>(size / std::sqrt(2.0)) + 1;
  const LaneFft fft(size);
  std::vector<LaneComplex> data(tile.size());
  Vec3 mean = Vec3::Zero();
  for (const Vec3f& v : tile) mean += v.cast<double>();
  const Vec3f middle = (mean / static_cast<double>(tile.size())).cast<float>();
  for (std::size_t i = 0; i < tile.size(); ++i) {
    const Vec3f v = axes.transpose() * (tile[i] - middle);
    data[i] = {Lane{v.x(), v.y(), v.z(), 0}, Lane{0, 0, 0, 0}};
  }
  transform(fft, data, false, work);
  equalize_directions(data, size, work);
  const SlicePower have(data, size, bins);
  std::array<std::vector<double>, 3> gain;
  for (std::size_t c = 0; c < 3; ++c)
    gain[c] = fitted_gains(have, c, wanted_power(covariance[c], size, bins));
  work.quiet().parallel(tile.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto low = std::min<std::size_t>(have.distance[i], have.radii() - 2);
      const double t = have.distance[i] - low;
      Lane lane = {0, 0, 0, 0};
      for (std::size_t c = 0; c < 3; ++c)
        lane[c] = std::sqrt((1 - t) * gain[c][low] + t * gain[c][low + 1]) / tile.size();
      data[i].re *= lane;
      data[i].im *= lane;
    }
  });
  transform(fft, data, true, work);
  for (std::size_t i = 0; i < tile.size(); ++i)
    tile[i] = axes * Vec3f(data[i].re[0], data[i].re[1], data[i].re[2]) + middle;
}

}  // namespace terrazzo::detail_solid
