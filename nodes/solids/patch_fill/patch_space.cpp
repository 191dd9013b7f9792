#include "nodes/solids/patch_fill/patch_space.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <tuple>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::patch_fill {
namespace {

using Basis = std::array<std::array<float, kPatch>, kPatch>;

const Basis& cosines() {
  static const Basis basis = [] {
    Basis b{};
    for (std::size_t u = 0; u < kPatch; ++u)
      for (std::size_t i = 0; i < kPatch; ++i)
        b[u][i] =
            std::sqrt((u == 0 ? 1.0 : 2.0) / kPatch) * std::cos(std::numbers::pi * (i + 0.5) * u / kPatch);
    return b;
  }();
  return basis;
}

constexpr std::size_t kVoxels = static_cast<std::size_t>(kPatch) * kPatch * kPatch;

// All coefficients of one channel of one patch, u fastest.
std::vector<float> transform(const Torus<Vec3f>& field, const Vec3i& start, int channel) {
  const Basis& b = cosines();
  std::vector<float> in(kVoxels), out(kVoxels);
  for (int z = 0; z < kPatch; ++z)
    for (int y = 0; y < kPatch; ++y)
      for (int x = 0; x < kPatch; ++x)
        in[(z * kPatch + y) * kPatch + x] = field.at[field.index(
            wrapped(start.x() + x, field.size.x()), wrapped(start.y() + y, field.size.y()),
            wrapped(start.z() + z, field.size.z()))][channel];
  for (const std::size_t step : {std::size_t{1}, std::size_t{kPatch}, std::size_t{kPatch} * kPatch}) {
    for (std::size_t i = 0; i < kVoxels; ++i) {
      const std::size_t u = i / step % kPatch, first = i - u * step;
      float sum = 0;
      for (std::size_t k = 0; k < kPatch; ++k) sum += b[u][k] * in[first + k * step];
      out[i] = sum;
    }
    std::swap(in, out);
  }
  return in;
}

}  // namespace

PatchSpace::PatchSpace(const Torus<Vec3f>& a, const Torus<Vec3f>& b, int dimensions, std::uint64_t seed) {
  constexpr std::size_t kSamples = 1000;  // patches of each solid
  std::vector<double> mean(3 * kVoxels), square(3 * kVoxels);
  for (std::size_t s = 0; s < 2 * kSamples; ++s) {
    const Torus<Vec3f>& field = s % 2 ? b : a;
    const Vec3i start = field.place(Random(seed, 0x71, s).below(field.at.size()));
    for (int c = 0; c < 3; ++c) {
      const std::vector<float> values = transform(field, start, c);
      for (std::size_t i = 0; i < kVoxels; ++i) {
        const std::size_t at = c * kVoxels + i;
        mean[at] += values[i];
        square[at] += static_cast<double>(values[i]) * values[i];
      }
    }
  }
  std::vector<double> variance(mean.size());
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const double m = mean[i] / (2 * kSamples);
    variance[i] = std::max(0.0, square[i] / (2 * kSamples) - m * m);
  }
  std::vector<std::size_t> order(mean.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return variance[i] > variance[j]; });
  double kept = 0;
  for (int k = 0; k < dimensions; ++k) {
    const std::size_t i = order[k], in = i % kVoxels;
    chosen_.push_back({static_cast<int>(i / kVoxels), static_cast<int>(in % kPatch),
                       static_cast<int>(in / kPatch % kPatch), static_cast<int>(in / kPatch / kPatch)});
    kept += variance[i];
  }
  share_ = kept / std::accumulate(variance.begin(), variance.end(), 0.0);
  std::sort(chosen_.begin(), chosen_.end(), [](const Coefficient& p, const Coefficient& q) {
    return std::tuple(p.channel, p.u, p.v, p.w) < std::tuple(q.channel, q.u, q.v, q.w);
  });
}

std::vector<float> PatchSpace::describe(const Torus<Vec3f>& field, int stride, const Work& work) const {
  const Basis& basis = cosines();
  const Vec3i n = field.size, starts = (n.array() + stride - 1) / stride;
  const std::size_t dims = dimensions();
  const std::size_t plane = pixels_in(n.x(), n.y());
  std::vector<float> out(dims * starts.x() * starts.y() * starts.z());
  // Filtered along x, then y, then z. Sorted coefficients share the first two steps.
  std::vector<float> along_x(field.at.size()), along_y(field.at.size());
  for (std::size_t d = 0; d < dims; ++d) {
    const Coefficient& k = chosen_[d];
    const auto same = [&](auto... member) { return d > 0 && ((k.*member == chosen_[d - 1].*member) && ...); };
    const auto& bu = basis[k.u];
    const auto& bv = basis[k.v];
    const auto& bw = basis[k.w];
    if (!same(&Coefficient::channel, &Coefficient::u))
      work.parallel(static_cast<std::size_t>(n.y()) * n.z(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
          for (int x = 0; x < n.x(); ++x) {
            float sum = 0;
            for (int i = 0; i < kPatch; ++i)
              sum += bu[i] * field.at[row * n.x() + wrapped(x + i, n.x())][k.channel];
            along_x[row * n.x() + x] = sum;
          }
      });
    if (!same(&Coefficient::channel, &Coefficient::u, &Coefficient::v))
      work.parallel(n.z(), 1, [&](std::size_t z, std::size_t) {
        for (int y = 0; y < n.y(); ++y) {
          float* to = &along_y[z * plane + static_cast<std::size_t>(y) * n.x()];
          std::fill_n(to, n.x(), 0.0f);
          for (int i = 0; i < kPatch; ++i) {
            const float* from = &along_x[z * plane + static_cast<std::size_t>(wrapped(y + i, n.y())) * n.x()];
            for (int x = 0; x < n.x(); ++x) to[x] += bv[i] * from[x];
          }
        }
      });
    work.parallel(starts.z(), 1, [&](std::size_t sz, std::size_t) {
      std::size_t at = sz * starts.x() * starts.y();
      for (int y = 0; y < n.y(); y += stride)
        for (int x = 0; x < n.x(); x += stride, ++at) {
          float sum = 0;
          for (int i = 0; i < kPatch; ++i)
            sum +=
                bw[i] *
                along_y[(wrapped(static_cast<int>(sz) * stride + i, n.z())) * plane + pixel_at(x, y, n.x())];
          out[at * dims + d] = sum;
        }
    });
  }
  return out;
}

}  // namespace terrazzo::patch_fill
