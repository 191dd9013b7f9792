#include "nodes/packing/measure3d/correlation.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "nodes/common/texture/block_fft.h"
#include "nodes/common/texture/lane_fft.h"
#include "nodes/data/indices.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

using Complex = std::complex<float>;

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
  transform_block(field, padded, false, work.part(0, 0.4));
  for (Complex& v : field) v = std::norm(v);
  transform_block(field, padded, true, work.part(0.4, 0.8));
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
