#include "nodes/detail_solid/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/texture/lane_fft.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kLags = 24;                            // pixels
constexpr int kWindow = 464;                         // most pixels per side that are transformed
constexpr int kFitRounds = 20;                       // of fitting the filter
constexpr double kLeastGain = 0.01, kMostGain = 16;  // of the power, relative to its mean
constexpr double kPi = std::numbers::pi;

constexpr int kSide = 2 * kLags + 1;

// Covariance of pixels by lag, (2·kLags + 1)² values, summed over the channels, relative to mean 0. Empty if
// there are too few pixels.
std::vector<double> covariance_of(const Phases& p, int phase) {
  const int w = std::min(p.width, kWindow), h = std::min(p.height, kWindow);
  const LaneFft2 fft(fast_even_size_above(w + kLags), fast_even_size_above(h + kLags));
  std::vector<double> sum(kSide * kSide, 0.0), pairs(kSide * kSide, 0.0);
  std::vector<LaneComplex> scratch;
  // Windows in the middle of every section.
  const int x0 = (p.width - w) / 2, y0 = (p.height - h) / 2;
  const int sections = std::min(p.sections, 8);
  for (int s = 0; s < sections; ++s) {
    std::vector<LaneComplex> data(fft.count(), LaneComplex{Lane{0, 0, 0, 0}, Lane{0, 0, 0, 0}});
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const std::size_t i = s * p.plane() + static_cast<std::size_t>(y0 + y) * p.width + x0 + x;
        if (p.phase[i] != phase) continue;
        const Vec3f& v = p.offset[i];
        data[static_cast<std::size_t>(y) * fft.width() + x].re = Lane{v.x(), v.y(), v.z(), 1};
      }
    // The transform of a real signal's power in each lane is the signal's covariance.
    fft.run(data.data(), false, scratch);
    for (LaneComplex& c : data) c.re = c.re * c.re + c.im * c.im, c.im = Lane{0, 0, 0, 0};
    fft.run(data.data(), true, scratch);
    const double scale = 1.0 / static_cast<double>(fft.count());
    for (int dy = -kLags; dy <= kLags; ++dy)
      for (int dx = -kLags; dx <= kLags; ++dx) {
        const Lane& c = data[static_cast<std::size_t>((dy + fft.height()) % fft.height()) * fft.width() +
                             (dx + fft.width()) % fft.width()]
                            .re;
        const auto k = static_cast<std::size_t>((dy + kLags) * kSide + dx + kLags);
        sum[k] += scale * (c[0] + c[1] + c[2]), pairs[k] += scale * c[3];
      }
  }
  if (pairs[kSide * kLags + kLags] < 256) return {};
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = pairs[k] >= 64 ? sum[k] / pairs[k] : 0;
  return sum;
}

// Power per frequency cell of slices of size² pixels, by radial bin |q| of the slice's frequencies. Beyond
// size/2 there are only frequencies near the diagonals.
std::vector<double> wanted_power(const std::vector<double>& covariance, int size, std::size_t bins) {
  constexpr int kDirections = 32;
  std::vector<double> out;
  for (std::size_t q = 0; q < bins; ++q) {
    const double k = 2 * kPi * static_cast<double>(q) / size;
    double power = 0, directions = 0;
    for (int a = 0; a < kDirections; ++a) {
      const double angle = kPi * (a + 0.5) / kDirections, kx = k * std::cos(angle), ky = k * std::sin(angle);
      if (std::max(std::abs(kx), std::abs(ky)) > kPi) continue;
      ++directions;
      for (int dy = -kLags; dy <= kLags; ++dy)
        for (int dx = -kLags; dx <= kLags; ++dx) {
          const double window =
              0.25 * (1 + std::cos(kPi * dx / (kLags + 1))) * (1 + std::cos(kPi * dy / (kLags + 1)));
          power += window * covariance[static_cast<std::size_t>((dy + kLags) * kSide + dx + kLags)] *
                   std::cos(kx * dx + ky * dy);
        }
    }
    out.push_back(directions > 0 ? std::max(power / directions, 0.0) : out.back());
  }
  return out;
}

// Transforms a cube along all axes.
void transform(const LaneFft& fft, std::vector<LaneComplex>& data, bool inverse, const Work& work) {
  const auto n = static_cast<std::size_t>(fft.size()), plane = n * n;
  work.quiet().parallel(n, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> scratch(plane);
    for (std::size_t z = begin; z < end; ++z) {
      for (std::size_t y = 0; y < n; ++y) fft.run(&data[z * plane + y * n], scratch.data(), 1, inverse);
      fft.run(&data[z * plane], scratch.data(), static_cast<int>(n), inverse);
    }
  });
  work.quiet().parallel(n, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<LaneComplex> columns(plane), scratch(plane);
    for (std::size_t y = begin; y < end; ++y) {
      for (std::size_t z = 0; z < n; ++z) std::copy_n(&data[z * plane + y * n], n, &columns[z * n]);
      fft.run(columns.data(), scratch.data(), static_cast<int>(n), inverse);
      for (std::size_t z = 0; z < n; ++z) std::copy_n(&columns[z * n], n, &data[z * plane + y * n]);
    }
  });
}

}  // namespace

void match_spectrum(std::vector<Vec3f>& tile, int size, const Phases& phases, int phase, const Work& work) {
  if (phases.pixels[static_cast<std::size_t>(phase)] < 256) return;
  const std::vector<double> covariance = covariance_of(phases, phase);
  if (covariance.empty()) return;
  const auto n = static_cast<std::size_t>(size), bins = static_cast<std::size_t>(size / std::sqrt(2.0)) + 1;
  const std::vector<double> wanted = wanted_power(covariance, size, bins);
  const LaneFft fft(size);
  std::vector<LaneComplex> data(tile.size());
  Vec3 mean = Vec3::Zero();
  for (const Vec3f& v : tile) mean += v.cast<double>();
  const Vec3f middle = (mean / static_cast<double>(tile.size())).cast<float>();
  for (std::size_t i = 0; i < tile.size(); ++i) {
    const Vec3f v = tile[i] - middle;
    data[i] = {Lane{v.x(), v.y(), v.z(), 0}, Lane{0, 0, 0, 0}};
  }
  transform(fft, data, false, work);
  // Power by radial frequency in space (ρ) and in the slices across each axis (q): a slice adds up all
  // frequencies along its axis.
  const std::size_t most = static_cast<std::size_t>(std::ceil(std::sqrt(3.0) * size / 2)) + 2;
  std::vector<double> power(bins * most, 0.0), cells(bins, 0.0);
  std::vector<double> distance(tile.size());
  const auto frequency = [&](std::size_t i) {
    return i <= n / 2 ? static_cast<double>(i) : static_cast<double>(i) - static_cast<double>(n);
  };
  std::size_t at = 0;
  for (std::size_t z = 0; z < n; ++z)
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t x = 0; x < n; ++x, ++at) {
        const Vec3 f(frequency(x), frequency(y), frequency(z));
        distance[at] = f.norm();
        const Lane p = data[at].re * data[at].re + data[at].im * data[at].im;
        const double sum = static_cast<double>(p[0]) + p[1] + p[2];
        const auto rho = static_cast<std::size_t>(std::lround(distance[at]));
        for (int a = 0; a < 3; ++a) {
          const auto q =
              static_cast<std::size_t>(std::lround(std::sqrt(std::max(0.0, f.squaredNorm() - f[a] * f[a]))));
          if (q < bins) power[q * most + rho] += sum;
        }
      }
  for (std::size_t y = 0; y < n; ++y)
    for (std::size_t x = 0; x < n; ++x) {
      const auto q = static_cast<std::size_t>(std::lround(std::hypot(frequency(x), frequency(y))));
      if (q < bins) ++cells[q];
    }
  // Mean power of a slice's frequency cell, in the units of wanted_power: Σ_z |F|² / n · (1 / n²) per cell.
  const double unit = 1.0 / (3.0 * std::pow(static_cast<double>(n), 4));
  const auto power_at = [&](std::size_t q, const std::vector<double>& by) {
    double have = 0;
    for (std::size_t r = 0; r < most; ++r) have += power[q * most + r] * by[r];
    return have * unit / std::max(cells[q], 1.0);
  };
  std::vector<double> gain(most, 1.0);  // of the power, by ρ
  double all = 0, given = 0;
  for (std::size_t q = 1; q < bins; ++q) all += cells[q] * wanted[q], given += cells[q] * power_at(q, gain);
  if (!(all > 0) || !(given > 0)) return;
  const double start = all / given;
  gain.assign(most, start);
  for (int round = 0; round < kFitRounds; ++round) {
    std::vector<double> next = gain;
    for (std::size_t q = 1; q < bins; ++q) {
      const double have = power_at(q, gain);
      if (have > 0)
        next[q] =
            std::clamp(gain[q] * std::pow(wanted[q] / have, 0.7), kLeastGain * start, kMostGain * start);
    }
    for (std::size_t r = bins; r < most; ++r) next[r] = next[bins - 1];
    gain = std::move(next);
  }
  work.quiet().parallel(tile.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto low = std::min(static_cast<std::size_t>(distance[i]), most - 2);
      const double t = distance[i] - static_cast<double>(low);
      const auto g = static_cast<float>(std::sqrt((1 - t) * gain[low] + t * gain[low + 1]) /
                                        static_cast<double>(tile.size()));
      const Lane lane = {g, g, g, g};
      data[i].re *= lane, data[i].im *= lane;
    }
  });
  transform(fft, data, true, work);
  for (std::size_t i = 0; i < tile.size(); ++i)
    tile[i] = Vec3f(data[i].re[0], data[i].re[1], data[i].re[2]) + middle;
}

}  // namespace terrazzo::detail_solid
