#include "nodes/detail/detail_solid/isotropy.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/data/linear.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kTowards = 48;  // on half of the sphere
constexpr float kWidth = 10;  // of the window: exp(width (cos² − 1))
constexpr double kShell = 4;  // thickness of the shells over which power is summed, frequencies
constexpr float kLeastFactor = 0.25f, kMostFactor = 4;

std::array<Vec3f, kTowards> directions() {
  std::array<Vec3f, kTowards> out;
  for (int k = 0; k < kTowards; ++k) {
    const double z = (k + 0.5) / kTowards, a = k * 2.399963229728653, r = std::sqrt(1 - z * z);
    out[k] = Vec3(r * std::cos(a), r * std::sin(a), z).cast<float>();
  }
  return out;
}

// Sums of one shell.
struct Shell {
  std::array<Lane, kTowards> power{};
  std::array<float, kTowards> weight{};
  Lane all{};
  float count = 0;
};

using DirectionWeights = std::array<float, kTowards>;

// The frequencies of a cube, in shells and directions.
struct Spectrum {
  std::size_t n;
  std::size_t shells;
  std::array<Vec3f, kTowards> towards = directions();

  explicit Spectrum(int size)
      : n(size), shells(static_cast<std::size_t>(std::sqrt(3.0) * size / 2 / kShell) + 2) {}

  float frequency(std::size_t i) const {
    return i <= n / 2 ? static_cast<float>(i) : static_cast<float>(i) - n;
  }

  // Calls use(element, shell below, share of the shell above, weights of the directions) for each frequency
  // of plane z but the origin.
  template <class Use>
  void each(std::size_t z, Use&& use) const {
    DirectionWeights weight;
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t x = 0; x < n; ++x) {
        const Vec3f f(frequency(x), frequency(y), frequency(z));
        const float distance = f.norm();
        if (!(distance > 0)) continue;
        const Vec3f unit = f / distance;
        for (std::size_t k = 0; k < kTowards; ++k) {
          const float c = unit.dot(towards[k]), e = kWidth * (c * c - 1);
          // Within 1e-3 of the exponential, and the same on every machine.
          float w = std::max(0.0f, 1 + e / 16);
          w *= w;
          w *= w;
          w *= w;
          w *= w;
          weight[k] = w;
        }
        const float at = distance / static_cast<float>(kShell);
        const auto low = std::min<std::size_t>(at, shells - 2);
        use((z * n + y) * n + x, low, at - low, weight);
      }
  }
};

std::vector<Shell> sum_shells(const std::vector<LaneComplex>& data, const Spectrum& spectrum,
                              const Work& work) {
  // Each plane has sums of its own, so that any number of threads adds in the same order.
  std::vector<std::vector<Shell>> planes(spectrum.n);
  work.parallel(spectrum.n, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z) {
      auto& sums = planes[z];
      sums.assign(spectrum.shells, {});
      spectrum.each(z, [&](std::size_t i, std::size_t low, float t, const DirectionWeights& weight) {
        Shell& s = sums[low + (t >= 0.5f ? 1 : 0)];
        const Lane power = data[i].re * data[i].re + data[i].im * data[i].im;
        s.all += power;
        ++s.count;
        for (std::size_t k = 0; k < kTowards; ++k) {
          s.power[k] += weight[k] * power;
          s.weight[k] += weight[k];
        }
      });
    }
  });
  std::vector<Shell> sums(spectrum.shells);
  for (const auto& plane : planes)
    for (std::size_t r = 0; r < sums.size(); ++r) {
      sums[r].all += plane[r].all;
      sums[r].count += plane[r].count;
      for (std::size_t k = 0; k < kTowards; ++k) {
        sums[r].power[k] += plane[r].power[k];
        sums[r].weight[k] += plane[r].weight[k];
      }
    }
  return sums;
}

// The factor toward each direction that gives it the mean power of the shell.
std::array<Lane, kTowards> gains_of(const Shell& s) {
  std::array<Lane, kTowards> gain;
  for (std::size_t k = 0; k < kTowards; ++k)
    for (int c = 0; c < 4; ++c) {
      const float mean = s.count > 0 ? s.all[c] / s.count : 0;
      gain[k][c] = s.weight[k] > 1 && s.power[k][c] > 0 && mean > 0
                       ? std::clamp(std::sqrt(mean * s.weight[k] / s.power[k][c]), kLeastFactor, kMostFactor)
                       : 1.0f;
    }
  return gain;
}

}  // namespace

void equalize_directions(std::vector<LaneComplex>& data, int size, const Work& work) {
  const Spectrum spectrum(size);
  std::vector<std::array<Lane, kTowards>> gain;
  for (const Shell& s : sum_shells(data, spectrum, work.quiet())) gain.push_back(gains_of(s));
  work.quiet().parallel(spectrum.n, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z)
      spectrum.each(z, [&](std::size_t i, std::size_t low, float t, const DirectionWeights& weight) {
        Lane sum{};
        float all = 0;
        for (std::size_t k = 0; k < kTowards; ++k) {
          sum += weight[k] * ((1 - t) * gain[low][k] + t * gain[low + 1][k]);
          all += weight[k];
        }
        sum /= all;
        data[i].re *= sum;
        data[i].im *= sum;
      });
  });
}

}  // namespace terrazzo::detail_solid
