#include "nodes/packing/measure3d/subvolumes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "nodes/data/indices.h"

namespace terrazzo::measure3d {
namespace {

constexpr int kWaves = 2;              // periods per edge
constexpr double kSmallestWindow = 4;  // voxels
using Wave = std::complex<double>;
constexpr int kAcross = 2 * kWaves + 1;
using Amplitudes =
    std::array<Wave, kAcross * kAcross*(kWaves + 1)>;  // by wave in z, y (from −kWaves), x (from 0)

std::vector<Wave> wave_of(int periods, int n) {
  std::vector<Wave> out;
  for (int i = 0; i < n; ++i) out.push_back(std::polar(1.0, -2 * M_PI * periods * i / n));
  return out;
}

Amplitudes amplitudes_of(const Raster& raster, const Work& work) {
  const Vec3i& n = raster.box.size;
  std::vector<std::vector<Wave>> wave[3];
  for (int a = 0; a < 3; ++a)
    for (int k = a == 0 ? 0 : -kWaves; k <= kWaves; ++k) wave[a].push_back(wave_of(k, n[a]));
  return work.reduce<Amplitudes>(
      n.z(), 4, {},
      [&](std::size_t begin, std::size_t end) {
        Amplitudes part{};
        for (std::size_t z = begin; z < end; ++z) {
          work.check();
          std::array<Wave, kAcross*(kWaves + 1)> plane{};
          for (int y = 0; y < n.y(); ++y) {
            const std::uint8_t* row = &raster.in[raster.index(0, y, z)];
            for (int kx = 0; kx <= kWaves; ++kx) {
              const std::vector<Wave>& w = wave[0][kx];
              Wave sum = 0;
              for (int x = 0; x < n.x(); ++x)
                if (row[x]) sum += w[x];
              for (std::size_t ky = 0; ky < kAcross; ++ky)
                plane[ky * (kWaves + 1) + kx] += wave[1][ky][y] * sum;
            }
          }
          for (std::size_t kz = 0; kz < kAcross; ++kz)
            for (std::size_t k = 0; k < plane.size(); ++k)
              part[kz * plane.size() + k] += wave[2][kz][z] * plane[k];
        }
        return part;
      },
      [](Amplitudes a, const Amplitudes& b) {
        for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
        return a;
      });
}

// Numbers of voxels of the phase before each corner, modulo 2³².
struct SummedVolume {
  Vec3i size;
  std::vector<std::uint32_t> sums;
  explicit SummedVolume(const Raster& raster) : size(raster.box.size + Vec3i::Ones()) {
    sums.assign(voxels_in(size), 0);
    for (int z = 1; z < size.z(); ++z)
      for (int y = 1; y < size.y(); ++y) {
        std::uint32_t row = 0;
        for (int x = 1; x < size.x(); ++x) {
          row += raster.in[raster.index(x - 1, y - 1, z - 1)];
          sums[at(x, y, z)] = row + sums[at(x, y - 1, z)] + sums[at(x, y, z - 1)] - sums[at(x, y - 1, z - 1)];
        }
      }
  }
  std::size_t at(int x, int y, int z) const { return voxel_at(x, y, z, size); }
  std::uint32_t inside(const Vec3i& lo, const Vec3i& hi) const {
    std::uint32_t sum = 0;
    for (int k = 0; k < 8; ++k) {
      const bool x = k & 1, y = k & 2, z = k & 4;
      const std::uint32_t v = sums[at(x ? hi.x() : lo.x(), y ? hi.y() : lo.y(), z ? hi.z() : lo.z())];
      sum += (x + y + z) % 2 == 1 ? v : 0u - v;
    }
    return sum;
  }
  // The window may reach beyond the upper sides of the box, where it wraps.
  std::uint32_t window(const Vec3i& lo, const Vec3i& length) const {
    std::uint32_t sum = 0;
    for (int k = 0; k < 8; ++k) {
      Vec3i from = lo, to = lo + length;
      bool any = true;
      for (int a = 0; a < 3; ++a) {
        const int n = size[a] - 1;
        if (k >> a & 1) {
          from[a] = 0;
          to[a] -= n;
        } else
          to[a] = std::min(to[a], n);
        any = any && to[a] > from[a];
      }
      if (any) sum += inside(from, to);
    }
    return sum;
  }
};

// Standard deviation of the volume fraction in windows at all positions, up to a quarter window apart.
double window_deviation(const Raster& raster, const SummedVolume& sums, const Vec3i& length,
                        const Work& work) {
  Vec3i step, places;
  for (int a = 0; a < 3; ++a) {
    step[a] = std::max(1, length[a] / 4);
    const int room = raster.box.periodic ? raster.box.size[a] : raster.box.size[a] - length[a] + 1;
    places[a] = (room + step[a] - 1) / step[a];
  }
  const double mean = raster.fraction(), voxels = length.cast<double>().prod();
  const double squares = work.reduce<double>(
      places.z(), 1, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t z = begin; z < end; ++z)
          for (int y = 0; y < places.y(); ++y)
            for (int x = 0; x < places.x(); ++x) {
              const Vec3i lo = Vec3i(x, y, static_cast<int>(z)).cwiseProduct(step);
              const double d = sums.window(lo, length) / voxels - mean;
              sum += d * d;
            }
        return sum;
      },
      [](double a, double b) { return a + b; });
  return std::sqrt(squares / places.cast<double>().prod());
}

}  // namespace

Representative representative_volume(const Raster& raster, double precision, const Work& work) {
  Representative out;
  const Vec3i& n = raster.box.size;
  const double phi = raster.fraction(), variance = phi * (1 - phi);
  if (!(variance > 0)) return out;
  const double volume = raster.count() * raster.voxel_volume();
  const Amplitudes amplitude = amplitudes_of(raster, work.part(0, 0.3));
  double sum = 0;
  int waves = 0;  // of which the opposite one is not counted
  for (int kz = -kWaves; kz <= kWaves; ++kz)
    for (int ky = -kWaves; ky <= kWaves; ++ky)
      for (int kx = 0; kx <= kWaves; ++kx) {
        const int square = kx * kx + ky * ky + kz * kz;
        if (square == 0 || square > kWaves * kWaves) continue;
        if (kx == 0 && (ky < 0 || (ky == 0 && kz < 0))) continue;
        if (2 * kx >= n.x() || 2 * std::abs(ky) >= n.y() || 2 * std::abs(kz) >= n.z()) continue;
        const std::size_t at = ((kz + kWaves) * kAcross + ky + kWaves) * (kWaves + 1) + kx;
        sum += std::norm(amplitude[at]);
        ++waves;
      }
  if (waves > 0) {
    const double count = raster.count();
    out.integral_range = sum / waves * volume / (count * count) / variance;
    out.integral_range_error =
        out.integral_range / std::sqrt(waves);  // each wave is exponentially distributed
    out.fraction_error = std::sqrt(variance * out.integral_range / volume);
    out.edge = std::cbrt(4 * (1 - phi) / phi * out.integral_range / (precision * precision));
    out.edge_error = out.edge / 3 * out.integral_range_error / out.integral_range;
  }
  const SummedVolume sums(raster);
  const Vec3& spacing = raster.box.spacing;
  const double shortest = n.cast<double>().cwiseProduct(spacing).minCoeff();
  for (double edge = 0.5 * shortest; edge >= kSmallestWindow * spacing.maxCoeff(); edge /= std::sqrt(2.0)) {
    Vec3i length;
    for (int a = 0; a < 3; ++a) length[a] = std::clamp(round_nearest(edge / spacing[a]), 1, n[a]);
    Subvolumes row;
    const double part = length.cast<double>().cwiseProduct(spacing).prod();
    row.edge = std::cbrt(part);
    row.count = volume / part;
    row.deviation = window_deviation(raster, sums, length, work.part(0.3, 1).quiet());
    row.error = row.deviation / std::sqrt(2 * std::max(1.0, row.count - 1));
    row.expected = std::sqrt(variance * out.integral_range / part * (1 - part / volume));
    out.table.push_back(row);
  }
  return out;
}

}  // namespace terrazzo::measure3d
