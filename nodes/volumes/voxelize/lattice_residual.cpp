#include "nodes/volumes/voxelize/lattice_residual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/periodic.h"
#include "nodes/common/geometry/tile_fit.h"
#include "nodes/data/indices.h"
#include "nodes/data/volume.h"

namespace terrazzo::voxelize {
namespace {

constexpr int kLobes =
    6;  // white noise keeps 0.83 of its variance between samples; 0.7 with 3 lobes, 0.3 when trilinear

double sinc(double x) { return x == 0 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x); }

// One period as a dense array, x fastest.
std::vector<Vec3f> dense(const openvdb::Vec3SGrid& grid, const Vec3i& size, const Work& work) {
  std::vector<Vec3f> out(voxels_in(size));
  work.parallel(size.z(), 4, [&](std::size_t begin, std::size_t end) {
    auto accessor = grid.getConstAccessor();
    for (std::size_t k = begin; k < end; ++k)
      for (int j = 0; j < size.y(); ++j)
        for (int i = 0; i < size.x(); ++i) {
          const auto& v = accessor.getValue({i, j, static_cast<int>(k)});
          out[(k * size.y() + j) * size.x() + i] = {v[0], v[1], v[2]};
        }
  });
  return out;
}

}  // namespace

std::vector<LatticeResidual::Taps> LatticeResidual::taps(int out, int in, int periods) {
  const double ratio = static_cast<double>(in) * periods / out;  // input samples per output sample
  const double width = std::max(1.0, ratio);
  std::vector<Taps> all(out);
  for (int i = 0; i < out; ++i) {
    double u = (i + 0.5) * ratio - 0.5;
    if (std::abs(u - std::round(u)) < 1e-9) u = std::round(u);
    const int first = round_down(u - kLobes * width) + 1;
    const int last = round_up(u + kLobes * width) - 1;
    double sum = 0;
    std::vector<double> w;
    for (int s = first; s <= last; ++s) {
      const double x = (s - u) / width;
      const bool zero = width == 1 && s != u && x == std::round(x);
      w.push_back(zero ? 0 : sinc(x) * sinc(x / kLobes));
      sum += w.back();
    }
    all[i].first = first;
    for (const double v : w) all[i].weight.push_back(static_cast<float>(v / sum));
  }
  return all;
}

LatticeResidual::LatticeResidual(const Volume& residual, const Lattice& lattice, const Work& work)
    : lattice_(lattice) {
  const auto grid = residual.find<openvdb::Vec3SGrid>("residual");
  if (!grid)
    throw Error("no-residual", "the volume connected to 'residual' has no Vec3SGrid named residual",
                "connect ResidualSynth.volume");
  const Vec3i in = residual.resolution;
  if (in.minCoeff() < 1)
    throw Error("bad-residual", "the residual is not periodic",
                "connect a periodic volume, such as ResidualSynth.volume");
  const double voxel = grid->transform().voxelSize()[0];
  if (!(voxel > 0) || !std::isfinite(voxel))
    throw Error("bad-residual", "the residual's voxel size must be positive and finite");
  for (int a = 0; a < 3; ++a) {
    const double edge = lattice.size[a] * lattice.voxel, period = in[a] * voxel;
    const TileFit fit = fit_tile(edge, period);
    periods_[a] = fit.periods;
    scale_[a] = fit.scale;
  }
  std::vector<Vec3f> source = dense(*grid, in, work);
  if (std::any_of(source.begin(), source.end(), [](const Vec3f& v) { return !v.allFinite(); }))
    throw Error("bad-residual", "the residual contains NaN or infinity");

  const auto x = taps(lattice.size.x(), in.x(), periods_.x()),
             y = taps(lattice.size.y(), in.y(), periods_.y());
  z_ = taps(lattice.size.z(), in.z(), periods_.z());
  planes_ = in.z();
  const int nx = lattice.size.x(), ny = lattice.size.y();
  field_.resize(static_cast<std::size_t>(nx) * ny * planes_);
  work.parallel(planes_, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3f> rows(static_cast<std::size_t>(nx) * in.y());
    for (std::size_t k = begin; k < end; ++k) {
      for (int j = 0; j < in.y(); ++j) {
        const Vec3f* row = &source[(k * in.y() + j) * in.x()];
        for (int i = 0; i < nx; ++i) {
          Vec3f sum = Vec3f::Zero();
          for (std::size_t t = 0; t < x[i].weight.size(); ++t)
            sum += x[i].weight[t] * row[wrap_index(x[i].first + static_cast<int>(t), in.x())];
          rows[pixel_at(i, j, nx)] = sum;
        }
      }
      for (int j = 0; j < ny; ++j) {
        Vec3f* out = &field_[(k * ny + j) * nx];
        std::fill(out, out + nx, Vec3f::Zero());
        for (std::size_t t = 0; t < y[j].weight.size(); ++t) {
          const float w = y[j].weight[t];
          if (w == 0) continue;
          const Vec3f* row =
              &rows[static_cast<std::size_t>(wrap_index(y[j].first + static_cast<int>(t), in.y())) * nx];
          for (int i = 0; i < nx; ++i) out[i] += w * row[i];
        }
      }
    }
  });
}

void LatticeResidual::add_plane(int k, Vec3f* colors) const {
  const std::size_t plane = pixels_in(lattice_.size.x(), lattice_.size.y());
  for (std::size_t t = 0; t < z_[k].weight.size(); ++t) {
    const float w = z_[k].weight[t];
    if (w == 0) continue;
    const Vec3f* from = &field_[plane * wrap_index(z_[k].first + static_cast<int>(t), planes_)];
    for (std::size_t i = 0; i < plane; ++i) colors[i] += w * from[i];
  }
}

}  // namespace terrazzo::voxelize
