#include "nodes/render_solid/residual_field.h"

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/tile_fit.h"
#include "nodes/data/volume.h"
#include "nodes/render_solid/floor_of.h"
#include "runtime/random.h"

namespace terrazzo::render_solid {
namespace {

constexpr std::uint64_t particle_stream = 0x72657331, binder_stream = 0x72657332, layer_stream = 0x72657333;

int wrap(int i, int n) {
  i %= n;
  return i < 0 ? i + n : i;
}

// Converts samples of a period to the coefficients of the cubic spline through them, in place (Unser 1999).
void spline_coefficients(std::vector<Vec3f>& line) {
  const float z = std::sqrt(3.0f) - 2;
  const int n = static_cast<int>(line.size());
  const float around = 1 - std::pow(z, static_cast<float>(n));
  Vec3f first = Vec3f::Zero();
  float power = 1;
  for (int k = 0; k < n; ++k, power *= z) first += power * line[static_cast<std::size_t>(wrap(-k, n))];
  line[0] = first / around;
  for (int i = 1; i < n; ++i) line[static_cast<std::size_t>(i)] += z * line[static_cast<std::size_t>(i - 1)];
  Vec3f last = Vec3f::Zero();
  power = 1;
  for (int k = 0; k < n; ++k, power *= z) last += power * line[static_cast<std::size_t>(wrap(n - 1 + k, n))];
  Vec3f next = -z * last / around;
  line[static_cast<std::size_t>(n - 1)] = 6 * next;
  for (int i = n - 2; i >= 0; --i) {
    next = z * (next - line[static_cast<std::size_t>(i)]);
    line[static_cast<std::size_t>(i)] = 6 * next;
  }
}

void weights(float t, float w[4]) {
  const float s = 1 - t;
  w[0] = s * s * s / 6, w[1] = (4 - 6 * t * t + 3 * t * t * t) / 6;
  w[2] = (4 - 6 * s * s + 3 * s * s * s) / 6, w[3] = t * t * t / 6;
}

// Gradient noise with `cells` lattice steps per period; about −1 to 1.
float periodic_noise(const Vec3f& p, const Vec3i& cells) {
  int at[3];
  float f[3], u[3];
  for (int k = 0; k < 3; ++k) {
    at[k] = floor_of(p[k]);
    f[k] = p[k] - static_cast<float>(at[k]);
    u[k] = f[k] * f[k] * f[k] * (f[k] * (f[k] * 6 - 15) + 10);
  }
  float sum = 0;
  for (int c = 0; c < 8; ++c) {
    const int d[3] = {c & 1, c >> 1 & 1, c >> 2};
    std::uint64_t item = 0;
    float w = 1;
    for (int k = 0; k < 3; ++k) {
      item = item * 65537 + static_cast<std::uint64_t>(wrap(at[k] + d[k], cells[k]));
      w *= d[k] ? u[k] : 1 - u[k];
    }
    const std::uint64_t h = Random(1, layer_stream, item).bits();
    const auto side = [&](int bit) { return h >> bit & 1 ? 1.0f : -1.0f; };
    const int flat = static_cast<int>((h >> 8) % 3);  // a gradient towards one of the twelve edges
    float g = 0;
    for (int k = 0; k < 3; ++k)
      if (k != flat) g += side(k) * (f[k] - static_cast<float>(d[k]));
    sum += w * g;
  }
  return sum;
}

}  // namespace

ResidualField::ResidualField(const Volume& volume, const Vec3& box, const Work& work)
    : box_(box.cast<float>()) {
  const auto grid = volume.find<openvdb::Vec3SGrid>("residual");
  if (!grid)
    throw Error("no-residual", "the volume at input 'residual' has no Vec3SGrid named 'residual'",
                "connect ResidualSynth.volume");
  size_ = volume.resolution;
  if (size_.minCoeff() < 1)
    throw Error("bad-residual", "the residual is not periodic",
                "connect a periodic volume, for example from ResidualSynth");
  const double voxel = grid->transform().voxelSize()[0];
  if (!(voxel > 0) || !std::isfinite(voxel))
    throw Error("bad-residual", "the residual's voxel size is not positive");
  for (int a = 0; a < 3; ++a) {
    const TileFit fit = fit_tile(box[a], size_[a] * voxel);
    periods_[a] = fit.periods, scale_[a] = fit.scale;
    voxels_per_mm_[a] = static_cast<float>(fit.periods * size_[a] / box[a]);
  }
  const std::size_t nx = static_cast<std::size_t>(size_.x()), ny = static_cast<std::size_t>(size_.y()),
                    nz = static_cast<std::size_t>(size_.z());
  std::vector<Vec3f> values(nx * ny * nz);
  work.parallel(nz, 4, [&](std::size_t begin, std::size_t end) {
    auto accessor = grid->getConstAccessor();
    for (std::size_t k = begin; k < end; ++k)
      for (std::size_t j = 0; j < ny; ++j)
        for (std::size_t i = 0; i < nx; ++i) {
          const auto& v = accessor.getValue({static_cast<int>(i), static_cast<int>(j), static_cast<int>(k)});
          values[(k * ny + j) * nx + i] = {v[0], v[1], v[2]};
        }
  });
  if (std::any_of(values.begin(), values.end(), [](const Vec3f& v) { return !v.allFinite(); }))
    throw Error("bad-residual", "the residual contains NaN or infinity");
  const std::size_t step[3] = {1, nx, nx * ny};
  for (int a = 0; a < 3; ++a) {
    const int b = a == 0 ? 1 : 0, c = a == 2 ? 1 : 2;  // lines along a start at every (b, c)
    work.parallel(static_cast<std::size_t>(size_[c]), 4, [&](std::size_t begin, std::size_t end) {
      std::vector<Vec3f> line(static_cast<std::size_t>(size_[a]));
      for (std::size_t j = begin; j < end; ++j)
        for (std::size_t i = 0; i < static_cast<std::size_t>(size_[b]); ++i) {
          Vec3f* first = &values[j * step[c] + i * step[b]];
          for (std::size_t k = 0; k < line.size(); ++k) line[k] = first[k * step[a]];
          spline_coefficients(line);
          for (std::size_t k = 0; k < line.size(); ++k) first[k * step[a]] = line[k];
        }
    });
  }
  float most = 1e-6f;
  for (const Vec3f& v : values) most = std::max(most, v.cwiseAbs().maxCoeff());
  unit_ = most / 32767;
  coefficients_.reserve(3 * values.size());
  for (const Vec3f& v : values)
    for (int k = 0; k < 3; ++k) coefficients_.push_back(static_cast<std::int16_t>(std::lround(v[k] / unit_)));
}

Vec3f ResidualField::spline(const Vec3f& mm) const {
  std::size_t at[3][4];
  float w[3][4];
  const std::size_t step[3] = {1, static_cast<std::size_t>(size_.x()),
                               static_cast<std::size_t>(size_.x()) * size_.y()};
  for (int k = 0; k < 3; ++k) {
    const float p = mm[k] * voxels_per_mm_[k] - 0.5f;
    const int low = floor_of(p);
    weights(p - static_cast<float>(low), w[k]);
    for (int i = 0; i < 4; ++i) at[k][i] = static_cast<std::size_t>(wrap(low + i - 1, size_[k])) * step[k];
  }
  Vec3f sum = Vec3f::Zero();
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 4; ++y) {
      Vec3f row = Vec3f::Zero();
      for (int x = 0; x < 4; ++x) {
        const std::int16_t* c = &coefficients_[3 * (at[2][z] + at[1][y] + at[0][x])];
        row += w[0][x] * Vec3f(c[0], c[1], c[2]);
      }
      sum += w[2][z] * w[1][y] * row;
    }
  return unit_ * sum;
}

Vec3f ResidualField::moved(std::uint64_t stream, std::uint64_t item) const {
  Random random(1, stream, item);
  const auto x = static_cast<float>(random.uniform()), y = static_cast<float>(random.uniform());
  return Vec3f(x, y, static_cast<float>(random.uniform())).cwiseProduct(box_);
}

Vec3f ResidualField::at(const Vec3f& mm, int particle) const {
  if (periods_.maxCoeff() == 1) return spline(mm);
  if (particle >= 0) return spline(mm + moved(particle_stream, static_cast<std::uint64_t>(particle)));
  // Layers about a third of a tile thick.
  const float layer =
      5 * periodic_noise(mm.cwiseQuotient(box_).cwiseProduct(periods_.cast<float>()), periods_) + 100;
  const int low = floor_of(layer);
  float t = std::clamp((layer - static_cast<float>(low) - 0.3f) / 0.4f, 0.0f, 1.0f);
  t = t * t * (3 - 2 * t);
  const auto part = [&](int i) { return spline(mm + moved(binder_stream, static_cast<std::uint64_t>(i))); };
  if (t <= 0) return part(low);
  if (t >= 1) return part(low + 1);
  return ((1 - t) * part(low) + t * part(low + 1)) / std::sqrt(t * t + (1 - t) * (1 - t));
}

}  // namespace terrazzo::render_solid
