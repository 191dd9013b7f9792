#include "nodes/detail/residual_synth/start_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/common/texture/steerable_pyramid.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::residual_synth {
namespace {

constexpr double kPi = std::numbers::pi;

struct BandName {
  int scale, orientation;
};

std::vector<BandName> band_names(int scales) {
  std::vector<BandName> names;
  for (int s = 0; s <= scales + 1; ++s)
    for (int o = 0; o < (s == 0 || s > scales ? 1 : 4); ++o) names.push_back({s, o});
  return names;
}

// Frequencies of the cube [−π, π]³, each with the fraction of the cube's volume it represents.
struct Sample {
  Vec3 k;
  double weight;
};

std::vector<Sample> polar_grid() {
  constexpr int kShells = 28, kDirections = 192;
  const double lo = std::log(kPi / 128), hi = std::log(std::sqrt(3.0) * kPi), step = (hi - lo) / kShells;
  std::vector<Sample> out;
  for (int s = 0; s < kShells; ++s) {
    const double r0 = s == 0 ? 0 : std::exp(lo + s * step), r1 = std::exp(lo + (s + 1) * step);
    const double r = std::cbrt((r0 * r0 * r0 + r1 * r1 * r1) / 2);
    const double volume = 4.0 / 3 * kPi * (r1 * r1 * r1 - r0 * r0 * r0) / kDirections;
    for (int d = 0; d < kDirections; ++d) {
      // Fibonacci spiral, rotated a little in every shell.
      const double z = 1 - (2.0 * d + 1) / kDirections, phi = 2.399963229728653 * (d + 0.37 * s);
      const Vec3 k = r * Vec3(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
      if (k.cwiseAbs().maxCoeff() < kPi) out.push_back({k, volume / std::pow(2 * kPi, 3)});
    }
  }
  return out;
}

}  // namespace

PowerFactors fit_power(const std::array<const std::vector<Quantiles>*, 3>& bands, int scales) {
  const auto names = band_names(scales);
  const auto grid = polar_grid();
  const std::size_t nb = names.size();
  std::vector<double> response(grid.size() * 3 * nb);  // |transfer|²
  for (std::size_t j = 0; j < grid.size(); ++j)
    for (int a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < nb; ++b) {
        const double g = band_gain(names[b].scale, names[b].orientation, scales, grid[j].k[kSliceColumns[a]],
                                   grid[j].k[kSliceRows[a]]);
        response[(j * 3 + a) * nb + b] = g * g;
      }
  PowerFactors factor;
  for (auto& f : factor) f.assign(nb, 1);
  for (int round = 0; round < 60; ++round) {
    PowerFactors variance;
    for (auto& v : variance) v.assign(nb, 0);
    for (std::size_t j = 0; j < grid.size(); ++j) {
      double power = grid[j].weight;
      for (int a = 0; a < 3; ++a) {
        double g = 0;
        for (std::size_t b = 0; b < nb; ++b) g += factor[a][b] * response[(j * 3 + a) * nb + b];
        power *= g;
      }
      for (int a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < nb; ++b) variance[a][b] += power * response[(j * 3 + a) * nb + b];
    }
    for (int a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < nb; ++b) {
        const double deviation = (*bands[a])[b].deviation, wanted = deviation * deviation;
        const double ratio = variance[a][b] > 0 ? std::max(wanted, 1e-20) / variance[a][b] : 1;
        factor[a][b] *= std::pow(std::clamp(ratio, 1e-3, 1e3), 0.4);
      }
  }
  return factor;
}

std::vector<float> start_field(const PowerFactors& factor, const Vec3i& size,
                               const std::vector<SliceFamily>& families, SliceFamily::Workspace& space,
                               std::uint64_t seed, std::uint64_t stream, const Work& work) {
  std::vector<float> out(voxels_in(size));
  work.parallel(out.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      // The sum of four uniform numbers is close enough to Gaussian; variance 1.
      const std::uint64_t bits = Random(seed, stream, i).bits();
      const float sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
      out[i] = (sum - 131070.0f) * (std::numbers::sqrt3_v<float> / 65536);
    }
  });
  for (int a = 0; a < 3; ++a) families[a].filter(out, factor[a], space, work);
  return out;
}

}  // namespace terrazzo::residual_synth
