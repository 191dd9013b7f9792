#include "nodes/residual_synth/start_field.h"

#include <kissfft/kiss_fftnd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "nodes/common/slice_axes.h"
#include "nodes/common/steerable_pyramid.h"
#include "runtime/random.h"

namespace terrazzo {
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

// Frequencies of the cube [−π, π]³ with the volume that each stands for, as a share of the cube.
struct Sample {
  Vec3 k;
  double weight;
};

std::vector<Sample> polar_grid() {
  constexpr int shells = 28, directions = 192;
  const double lo = std::log(kPi / 128), hi = std::log(std::sqrt(3.0) * kPi), step = (hi - lo) / shells;
  std::vector<Sample> out;
  for (int s = 0; s < shells; ++s) {
    const double r0 = s == 0 ? 0 : std::exp(lo + s * step), r1 = std::exp(lo + (s + 1) * step);
    const double r = std::cbrt((r0 * r0 * r0 + r1 * r1 * r1) / 2);
    const double volume = 4.0 / 3 * kPi * (r1 * r1 * r1 - r0 * r0 * r0) / directions;
    for (int d = 0; d < directions; ++d) {
      // Fibonacci spiral, turned a little in every shell.
      const double z = 1 - (2.0 * d + 1) / directions, phi = 2.399963229728653 * (d + 0.37 * s);
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
        const double deviation = (*bands[static_cast<std::size_t>(a)])[b].deviation,
                     wanted = deviation * deviation;
        const double ratio = variance[a][b] > 0 ? std::max(wanted, 1e-20) / variance[a][b] : 1;
        factor[a][b] *= std::pow(std::clamp(ratio, 1e-3, 1e3), 0.4);
      }
  }
  return factor;
}

std::vector<float> start_field(const PowerFactors& factor, const Vec3i& size, int scales, std::uint64_t seed,
                               std::uint64_t stream, const Work& work) {
  const auto names = band_names(scales);
  // Square roots of the factors of the spectrum, on each axis' plane of frequencies.
  std::array<std::vector<float>, 3> plane;
  for (int a = 0; a < 3; ++a) {
    const int nu = size[kSliceColumns[a]], nv = size[kSliceRows[a]];
    for (int v = 0; v < nv; ++v)
      for (int u = 0; u < nu; ++u) {
        const double ku = 2 * kPi * (2 * u < nu ? u : u - nu) / nu,
                     kv = 2 * kPi * (2 * v < nv ? v : v - nv) / nv;
        double g = 0;
        for (std::size_t b = 0; b < names.size(); ++b) {
          const double h = band_gain(names[b].scale, names[b].orientation, scales, ku, kv);
          g += factor[a][b] * h * h;
        }
        plane[a].push_back(static_cast<float>(std::sqrt(g)));
      }
  }
  const std::size_t n = static_cast<std::size_t>(size.x()) * size.y() * size.z();
  std::vector<kiss_fft_cpx> spectrum(n), field(n);
  work.parallel(size.z(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z)
      for (int y = 0; y < size.y(); ++y)
        for (int x = 0; x < size.x(); ++x) {
          const std::size_t i = (z * size.y() + y) * size.x() + x;
          const float amplitude = plane[0][z * size.y() + y] * plane[1][z * size.x() + x] *
                                  plane[2][static_cast<std::size_t>(y) * size.x() + x];
          Random random(seed, stream, i);
          // Uniform noise of unit variance: sums of thousands of terms are Gaussian whatever the terms are.
          spectrum[i].r = amplitude * static_cast<float>(random.uniform(-1, 1) * std::numbers::sqrt3);
          spectrum[i].i = amplitude * static_cast<float>(random.uniform(-1, 1) * std::numbers::sqrt3);
        }
  });
  spectrum[0] = {0, 0};
  const int dims[3] = {size.z(), size.y(), size.x()};
  const std::unique_ptr<kiss_fftnd_state, void (*)(void*)> plan(
      kiss_fftnd_alloc(dims, 3, 1, nullptr, nullptr), std::free);
  kiss_fftnd(plan.get(), spectrum.data(), field.data());
  const float norm = 1 / std::sqrt(static_cast<float>(n));
  std::vector<float> out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = field[i].r * norm;
  return out;
}

}  // namespace terrazzo
