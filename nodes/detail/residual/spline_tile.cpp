#include "nodes/detail/residual/spline_tile.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "nodes/common/geometry/grid/floor_of.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"

namespace terrazzo::residual {
namespace {

// Converts samples of a period to the coefficients of the cubic spline through them, in place (Unser 1999).
void spline_coefficients(std::vector<Vec3f>& line) {
  const float z = std::sqrt(3.0f) - 2;
  const int n = line.size();
  const float around = 1 - std::pow(z, static_cast<float>(n));
  Vec3f first = Vec3f::Zero();
  float power = 1;
  for (int k = 0; k < n; ++k, power *= z) first += power * line[wrap_index(-k, n)];
  line[0] = first / around;
  for (int i = 1; i < n; ++i) line[i] += z * line[i - 1];
  Vec3f last = Vec3f::Zero();
  power = 1;
  for (int k = 0; k < n; ++k, power *= z) last += power * line[wrap_index(n - 1 + k, n)];
  Vec3f next = -z * last / around;
  line[n - 1] = 6 * next;
  for (int i = n - 2; i >= 0; --i) {
    next = z * (next - line[i]);
    line[i] = 6 * next;
  }
}

// Converts samples to the coefficients of the cubic spline that has their mean power at any frequency, by
// convolution: the integral of a spline's square weights its coefficients with the B-spline of order 7.
std::vector<float> power_kernel() {
  constexpr int kReach = 20, kSteps = 512;  // the kernel falls below 10⁻⁶ of its middle
  std::vector<float> kernel;
  for (int n = -kReach; n <= kReach; ++n) {
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double w = 2 * std::numbers::pi * (k + 0.5) / kSteps;
      const double power = (2416 + 2382 * std::cos(w) + 240 * std::cos(2 * w) + 2 * std::cos(3 * w)) / 5040;
      sum += std::cos(w * n) / std::sqrt(power);
    }
    kernel.push_back(static_cast<float>(sum / kSteps));
  }
  return kernel;
}

void weights(float t, float w[4]) {
  const float s = 1 - t;
  w[0] = s * s * s / 6;
  w[1] = (4 - 6 * t * t + 3 * t * t * t) / 6;
  w[2] = (4 - 6 * s * s + 3 * s * s * s) / 6;
  w[3] = t * t * t / 6;
}

// Calls use(line) for every line of the tile along axis a, and writes the changed line back.
template <class Use>
void each_line(std::vector<Vec3f>& values, const Vec3i& size, int a, const Work& work, Use&& use) {
  const std::size_t nx = size.x(), ny = size.y();
  const std::size_t step[3] = {1, nx, nx * ny};
  const int b = a == 0 ? 1 : 0, c = a == 2 ? 1 : 2;  // lines along a start at every (b, c)
  work.parallel(size[c], 4, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3f> line(size[a]);
    for (std::size_t j = begin; j < end; ++j)
      for (std::size_t i = 0; i < static_cast<std::size_t>(size[b]); ++i) {
        Vec3f* first = &values[j * step[c] + i * step[b]];
        for (std::size_t k = 0; k < line.size(); ++k) line[k] = first[k * step[a]];
        use(line);
        for (std::size_t k = 0; k < line.size(); ++k) first[k * step[a]] = line[k];
      }
  });
}

// Convolves a period with a Gaussian of `sigma` samples.
void smooth_line(std::vector<Vec3f>& line, const std::vector<float>& kernel, std::vector<Vec3f>& buffer) {
  const int n = line.size(), reach = count_of(kernel) / 2;
  buffer.assign(line.size(), Vec3f::Zero());
  for (int i = 0; i < n; ++i)
    for (int t = -reach; t <= reach; ++t) buffer[i] += kernel[t + reach] * line[wrap_index(i + t, n)];
  line.swap(buffer);
}

Vec3 mean_of(const std::vector<Vec3f>& values) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3f& v : values) sum += v.cast<double>();
  return sum / static_cast<double>(values.size());
}

double variance_of(const std::vector<Vec3f>& values) {
  const Vec3 mean = mean_of(values);
  double sum = 0;
  for (const Vec3f& v : values) sum += (v.cast<double>() - mean).squaredNorm();
  return sum / values.size();
}

}  // namespace

void widen_footprint(std::vector<Vec3f>& values, const Vec3i& size, double footprint, const Work& work) {
  if (footprint <= 1) return;
  // A box of `footprint` voxels has the variance of this Gaussian, less that of one voxel.
  const double sigma = std::sqrt((footprint * footprint - 1) / 12.0);
  const int reach = round_up(3 * sigma);
  std::vector<float> kernel;
  float total = 0;
  for (int t = -reach; t <= reach; ++t) {
    kernel.push_back(static_cast<float>(std::exp(-0.5 * t * t / (sigma * sigma))));
    total += kernel.back();
  }
  for (float& k : kernel) k /= total;
  const auto smooth = [&](std::vector<Vec3f>& v, int axis) {
    each_line(v, size, axis, work.quiet(), [&](std::vector<Vec3f>& line) {
      thread_local std::vector<Vec3f> buffer;
      smooth_line(line, kernel, buffer);
    });
  };
  // Deviation of the slices across each axis if only they are smoothed.
  double slices = 0;
  std::vector<Vec3f> all;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Vec3f> v = values;
    for (int a = 0; a < 3; ++a)
      if (a != axis) smooth(v, a);
    slices += variance_of(v) / 3;
    if (axis == 2) {
      smooth(v, 2);
      all = std::move(v);
    }
  }
  const double solid = variance_of(all);
  const float gain = solid > 0 ? std::sqrt(slices / solid) : 1;
  const Vec3f mean = mean_of(all).cast<float>();
  for (Vec3f& v : all) v = mean + gain * (v - mean);
  values = std::move(all);
}

SplineTile::SplineTile(std::vector<Vec3f> values, const Vec3i& size, Keep keep, const Work& work)
    : size_(size) {
  const std::vector<float> kernel = keep == Keep::Power ? power_kernel() : std::vector<float>();
  for (int a = 0; a < 3; ++a)
    each_line(values, size, a, work.quiet(), [&](std::vector<Vec3f>& line) {
      if (kernel.empty()) return spline_coefficients(line);
      thread_local std::vector<Vec3f> buffer;
      smooth_line(line, kernel, buffer);
    });
  float most = 1e-6f;
  for (const Vec3f& v : values) most = std::max(most, v.cwiseAbs().maxCoeff());
  unit_ = most / 32767;
  coefficients_.reserve(3 * values.size() + 1);
  for (const Vec3f& v : values)
    for (int k = 0; k < 3; ++k) coefficients_.push_back(static_cast<std::int16_t>(std::lround(v[k] / unit_)));
  coefficients_.push_back(0);  // at() reads four at a time
}

Vec3f SplineTile::at(const Vec3f& p) const {
  std::size_t at[3][4];
  float w[3][4];
  const std::size_t step[3] = {1, static_cast<std::size_t>(size_.x()), pixels_in(size_.x(), size_.y())};
  for (int k = 0; k < 3; ++k) {
    const int low = floor_of(p[k]);
    weights(p[k] - low, w[k]);
    for (int i = 0; i < 4; ++i) at[k][i] = wrap_index(low + i - 1, size_[k]) * step[k];
  }
  // Three channels and, unused, the first one of the next voxel. Two rows are read at once, which takes half
  // of the time, and added in order.
  using Lanes = float __attribute__((vector_size(16)));
  using Rows = float __attribute__((vector_size(32)));
  using Stored = std::int16_t __attribute__((vector_size(16)));
  Lanes sum = {};
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; y += 2) {
      const std::int16_t* const first = &coefficients_[3 * (at[2][z] + at[1][y])];
      const std::int16_t* const second = &coefficients_[3 * (at[2][z] + at[1][y + 1])];
      Rows rows = {};
      for (int x = 0; x < 4; ++x) {
        std::int64_t both[2];
        std::memcpy(&both[0], first + 3 * at[0][x], sizeof both[0]);
        std::memcpy(&both[1], second + 3 * at[0][x], sizeof both[1]);
        Stored c;
        std::memcpy(&c, both, sizeof c);
        rows += w[0][x] * __builtin_convertvector(c, Rows);
      }
      sum += w[2][z] * w[1][y] * Lanes{rows[0], rows[1], rows[2], rows[3]};
      sum += w[2][z] * w[1][y + 1] * Lanes{rows[4], rows[5], rows[6], rows[7]};
    }
  return unit_ * Vec3f(sum[0], sum[1], sum[2]);
}

}  // namespace terrazzo::residual
