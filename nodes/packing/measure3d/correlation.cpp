#include "nodes/packing/measure3d/correlation.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "nodes/common/texture/lane_fft.h"
#include "nodes/data/indices.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

using Complex = std::complex<float>;

// Transforms a block of `size` complex numbers, x fastest, along every axis. Unnormalized.
void transform(std::vector<Complex>& data, const Vec3i& size, bool inverse, const Work& work) {
  constexpr std::size_t kInner = 4, kLanes = 4, kLines = kInner * kLanes;
  const std::size_t stride[3] = {1, static_cast<std::size_t>(size.x()), pixels_in(size.x(), size.y())};
  for (int axis = 0; axis < 3; ++axis) {
    const LaneFft fft(size[axis]);
    const std::size_t n = size[axis];
    const std::size_t lines = data.size() / n;
    // The first element of each line: lines next to each other in memory come next to each other.
    const auto start = [&](std::size_t line) {
      return axis == 0 ? line * n : line / stride[axis] * stride[axis] * n + line % stride[axis];
    };
    work.part(axis / 3.0, (axis + 1) / 3.0)
        .parallel((lines + kLines - 1) / kLines, 16, [&](std::size_t begin, std::size_t end) {
          std::vector<LaneComplex> block(n * kInner), scratch(n * kInner);
          for (std::size_t b = begin; b < end; ++b) {
            const std::size_t first = b * kLines, count = std::min(kLines, lines - first);
            for (std::size_t l = 0; l < kLines; ++l) {
              const Complex* from = l < count ? data.data() + start(first + l) : nullptr;
              for (std::size_t i = 0; i < n; ++i) {
                const Complex v = from ? from[i * stride[axis]] : Complex(0);
                block[i * kInner + l / kLanes].re[l % kLanes] = v.real();
                block[i * kInner + l / kLanes].im[l % kLanes] = v.imag();
              }
            }
            fft.run(block.data(), scratch.data(), kInner, inverse);
            for (std::size_t l = 0; l < count; ++l) {
              Complex* to = data.data() + start(first + l);
              for (std::size_t i = 0; i < n; ++i)
                to[i * stride[axis]] = {block[i * kInner + l / kLanes].re[l % kLanes],
                                        block[i * kInner + l / kLanes].im[l % kLanes]};
            }
          }
        });
  }
}

// Number of segments from voxel to voxel along the axis that are entirely in the phase, by length in voxels.
std::vector<double> paths_inside(const Raster& raster, int axis, int reach) {
  const Vec3i& size = raster.box.size;
  const int n = size[axis], u = (axis + 1) % 3, v = (axis + 2) % 3;
  // By the number of voxels in a run; a line that is entirely inside and wraps has no ends.
  std::vector<std::uint64_t> runs(n + 1, 0);
  std::uint64_t endless = 0;
  Vec3i at;
  for (at[v] = 0; at[v] < size[v]; ++at[v])
    for (at[u] = 0; at[u] < size[u]; ++at[u]) {
      const auto in = [&](int i) {
        Vec3i p = at;
        p[axis] = i;
        return raster.in[raster.index(p.x(), p.y(), p.z())] != 0;
      };
      int begin = 0;  // where the first run may begin: behind a voxel that is outside
      if (raster.box.periodic) {
        while (begin < n && in(begin)) ++begin;
        if (begin == n) {
          ++endless;
          continue;
        }
      }
      int run = 0;
      for (int i = 0; i < n; ++i) {
        if (in((begin + i) % n)) {
          ++run;
        } else if (run > 0) {
          ++runs[run];
          run = 0;
        }
      }
      if (run > 0) ++runs[run];
    }
  std::vector<double> out(reach + 1, 0);
  for (int r = 0; r <= reach; ++r) {
    double sum = static_cast<double>(endless) * n;
    for (int length = r + 1; length <= n; ++length) sum += static_cast<double>(length - r) * runs[length];
    out[r] = sum;
  }
  return out;
}

// Values at multiples of `spacing`, interpolated at multiples of `step`. Both in mm.
std::vector<double> resampled(const std::vector<double>& values, double spacing, double step,
                              std::size_t rows) {
  std::vector<double> out;
  for (std::size_t k = 0; k < rows; ++k) {
    const double r = k * step / spacing;
    const auto i = std::min<std::size_t>(r, values.size() - 1), j = std::min(i + 1, values.size() - 1);
    const double t = r - i;
    out.push_back((1 - t) * values[i] + t * values[j]);
  }
  return out;
}

}  // namespace

Correlation correlate(const Raster& raster, std::uint64_t memory, const Work& work) {
  const Vec3i& n = raster.box.size;
  const Vec3& spacing = raster.box.spacing;
  const bool wraps = raster.box.periodic;
  Correlation out;
  out.step = spacing.minCoeff();
  const double reach = 0.5 * n.cast<double>().cwiseProduct(spacing).minCoeff();  // mm
  const auto rows = static_cast<std::size_t>(reach / out.step) + 1;
  Vec3i lags, padded;  // largest lag in voxels; size of the transform
  for (int a = 0; a < 3; ++a) {
    lags[a] = std::min(round_up(reach / spacing[a]), wraps ? n[a] / 2 : n[a] - 1);
    padded[a] = wraps ? n[a] : fast_even_size_above(n[a] + lags[a]);
  }
  const double total = padded.cast<double>().prod();
  require_memory(8 * total, memory, "the Fourier transform of the volume");
  std::vector<Complex> field(total);
  const auto at = [&](int x, int y, int z) {
    const std::size_t row = static_cast<std::size_t>(z) * padded.y() + y;
    return row * padded.x() + x;
  };
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x) field[at(x, y, z)] = raster.in[raster.index(x, y, z)];
  transform(field, padded, false, work.part(0, 0.4));
  for (Complex& v : field) v = std::norm(v);
  transform(field, padded, true, work.part(0.4, 0.8));
  // Share of the segments by a lag (dx, dy ≥ −lags, dz ≥ 0) whose ends are both in the phase.
  const auto two_point = [&](int dx, int dy, int dz) {
    double segments = 1;
    for (const auto& [a, d] : {std::pair(0, dx), std::pair(1, dy), std::pair(2, dz)})
      segments *= wraps ? n[a] : n[a] - std::abs(d);
    const auto wrapped = [&](int d, int a) { return d < 0 ? d + padded[a] : d; };
    return std::max(0.0, field[at(wrapped(dx, 0), wrapped(dy, 1), wrapped(dz, 2))].real() / total / segments);
  };
  for (int a = 0; a < 3; ++a) {
    std::vector<double> two, path = paths_inside(raster, a, lags[a]);
    for (int k = 0; k <= lags[a]; ++k) {
      two.push_back(two_point(a == 0 ? k : 0, a == 1 ? k : 0, a == 2 ? k : 0));
      path[k] /= static_cast<double>(raster.count()) / n[a] * (wraps ? n[a] : n[a] - k);
    }
    out.two_point[a] = resampled(two, spacing[a], out.step, rows);
    out.lineal_path[a] = resampled(path, spacing[a], out.step, rows);
  }
  // All lags with dz ≥ 0: those with dz < 0 have the same values.
  std::vector<double> weight(rows, 0), value(rows, 0), length(rows, 0);
  for (int dz = 0; dz <= lags.z(); ++dz) {
    work.check();
    for (int dy = -lags.y(); dy <= lags.y(); ++dy)
      for (int dx = -lags.x(); dx <= lags.x(); ++dx) {
        const double r = Vec3(dx, dy, dz).cwiseProduct(spacing).norm();
        const std::size_t k = r / out.step + 0.5;
        if (k >= rows) continue;
        weight[k] += 1;
        value[k] += two_point(dx, dy, dz);
        length[k] += r;
      }
  }
  for (std::size_t k = 0; k < rows; ++k) {
    out.mean.push_back(weight[k] > 0 ? value[k] / weight[k] : NAN);
    out.length.push_back(weight[k] > 0 ? length[k] / weight[k] : NAN);
  }
  return out;
}

}  // namespace terrazzo::measure3d
