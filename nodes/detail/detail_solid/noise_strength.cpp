#include "nodes/detail/detail_solid/noise_strength.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kBlocksApart = 4;  // pixels between blocks
constexpr std::size_t kFewest = 200, kMostBlocks = 60000;
// How many times further blocks may spread than those of Gaussian noise. That of one camera measures 1.05 to
// 1.3, with the slopes and edges that blocks contain.
constexpr double kEven = 1.6;
// The least share of the noise's power at wavelengths below 8 pixels: 0.74 at a blur of 0.7 pixels.
constexpr double kFine = 0.5;
constexpr float kMostChange = 4;  // of its variance between two levels that are not black or white

// Without the mean and slopes.
float energy_of(const Block& c) {
  double sum = 0;
  int count = 0;
  for (int v = 0; v < kBlock; ++v)
    for (int u = 0; u < kBlock; ++u)
      if (u + v >= 3) {
        sum += c(v, u) * c(v, u);
        ++count;
      }
  return sum / count;
}

struct Sample {
  Block coefficients;
  float energy;
  int level;
};

// Blotches of the material are coarse. At wavelengths above 8 pixels, the noise counts as at most twice as
// strong as just below.
void limit_coarse(Block& spectrum) {
  constexpr double kCoarse = 2.0 * kBlock / 8, kNext = 1.5 * kCoarse;
  double sum = 0, count = 0;
  const auto each = [&](auto&& use) {
    for (int v = 0; v < kBlock; ++v)
      for (int u = 0; u < kBlock; ++u) use(std::hypot(u, v), spectrum(v, u));
  };
  each([&](double frequency, float power) {
    if (frequency < kCoarse || frequency >= kNext) return;
    sum += power;
    ++count;
  });
  const float limit = 2 * sum / count;
  each([&](double frequency, float& power) {
    if (frequency < kCoarse) power = std::min(power, limit);
  });
}

// Of the power at wavelengths below 8 pixels, without the mean.
double fine_share(const Block& spectrum) {
  double fine = 0, all = 0;
  for (int v = 0; v < kBlock; ++v)
    for (int u = 0; u < kBlock; ++u) {
      if (u + v == 0) continue;
      all += spectrum(v, u);
      if (std::hypot(u, v) >= 2.0 * kBlock / 8) fine += spectrum(v, u);
    }
  return fine / all;
}

// Quantiles of the blocks' energies at each level.
struct Energies {
  std::array<float, kLightness> tenth{}, quarter{}, middle{};
  std::array<std::size_t, kLightness> blocks{};
  std::array<bool, kLightness> known{};
};

Energies energies_of(const std::vector<Sample>& samples) {
  std::array<std::vector<float>, kLightness> values;
  for (const Sample& s : samples) values[s.level].push_back(s.energy);
  Energies out;
  for (int k = 0; k < kLightness; ++k) {
    out.blocks[k] = values[k].size();
    if (out.blocks[k] < kLeastAtLevel) continue;
    out.tenth[k] = at_rank(values[k], out.blocks[k] / 10);
    out.quarter[k] = at_rank(values[k], out.blocks[k] / 4);
    out.middle[k] = at_rank(values[k], out.blocks[k] / 2);
    out.known[k] = out.tenth[k] > 1e-9f;
  }
  return out;
}

// Mean power of each coefficient relative to the block's energy; nothing with too few blocks.
std::optional<Block> spectrum_of(const std::vector<Sample>& samples, const Energies& energies) {
  Block sum = Block::Zero();
  std::size_t count = 0;
  for (const Sample& s : samples)
    if (energies.known[s.level] && s.energy > energies.tenth[s.level] &&
        s.energy < energies.middle[s.level]) {
      sum += s.coefficients.cwiseAbs2() / s.energy;
      ++count;
    }
  if (count < kFewest) return {};
  return Block(sum / count);
}

// The standard deviation of the logarithm of energies of Gaussian noise, which follow about a χ²
// distribution.
double spread_of(const Block& spectrum) {
  double sum = 0, squares = 0;
  for (int v = 0; v < kBlock; ++v)
    for (int u = 0; u < kBlock; ++u)
      if (u + v >= 3) {
        sum += spectrum(v, u);
        squares += spectrum(v, u) * spectrum(v, u);
      }
  return std::sqrt(2 * squares) / sum;
}

// How many times further energies spread than those of noise: the median over blocks.
double unevenness(const Energies& e, double spread) {
  constexpr double kTenth = 1.2816;  // quantile of the normal distribution
  std::vector<std::pair<double, std::size_t>> levels;
  std::size_t all = 0, below = 0;
  for (int k = 0; k < kLightness; ++k) {
    if (!e.known[k]) continue;
    levels.emplace_back(std::log(e.middle[k] / e.tenth[k]) / (kTenth * spread), e.blocks[k]);
    all += e.blocks[k];
  }
  std::sort(levels.begin(), levels.end());
  for (const auto& [value, blocks] : levels)
    if (2 * (below += blocks) >= all) return value;
  return 0;
}

// The ratio of the largest to the smallest variance of common levels but black and white, which cut noise
// off.
float change_of(const Energies& e, const std::array<float, kLightness>& variance) {
  std::size_t all = 0;
  for (int k = 0; k < kLightness; ++k)
    if (e.known[k]) all += e.blocks[k];
  float least = 0, most = 0;
  for (int k = 1; k + 1 < kLightness; ++k) {
    if (!e.known[k] || 20 * e.blocks[k] < all) continue;
    least = least > 0 ? std::min(least, variance[k]) : variance[k];
    most = std::max(most, variance[k]);
  }
  return least > 0 ? most / least : 1;
}

// `samples`: blocks of one channel.
Strength strength_of(const std::vector<Sample>& samples) {
  Strength out;
  const Energies energies = energies_of(samples);
  const std::optional<Block> spectrum = spectrum_of(samples, energies);
  if (!spectrum) return out;
  out.spectrum = *spectrum;
  const double spread = spread_of(out.spectrum);
  constexpr double kQuarter = 0.6745;  // quantile of the normal distribution
  const float to_mean = std::exp(kQuarter * spread);
  for (int k = 0; k < kLightness; ++k)
    if (energies.known[k]) out.at[k] = energies.quarter[k] * to_mean;
  out.of_a_camera = unevenness(energies, spread) <= kEven && fine_share(out.spectrum) >= kFine &&
                    change_of(energies, out.at) <= kMostChange;
  fill_levels(out.at, energies.known);
  limit_coarse(out.spectrum);
  return out;
}

}  // namespace

// Levels without a value take those of the nearest ones, between two linearly.
void fill_levels(std::array<float, kLightness>& at, const std::array<bool, kLightness>& known) {
  int last = -1;
  for (int k = 0; k < kLightness; ++k) {
    if (!known[k]) continue;
    for (int i = last + 1; i < k; ++i)
      at[i] = last < 0 ? at[k] : at[last] + (at[k] - at[last]) * float(i - last) / float(k - last);
    last = k;
  }
  for (int i = last + 1; i < kLightness && last >= 0; ++i) at[i] = at[last];
}

// Of each channel. Blocks are thinned out evenly.
std::array<Strength, 3> strengths_of(const std::vector<Plane>& planes, const Work& work) {
  std::vector<std::array<int, 3>> places;
  for (int s = 0; s < count_of(planes); ++s)
    for (int y = 0; y + kBlock <= planes[s].height; y += kBlocksApart) {
      work.check();
      for (int x = 0; x + kBlock <= planes[s].width; x += kBlocksApart)
        if (planes[s].even(x, y)) places.push_back({s, x, y});
    }
  const std::size_t every = places.size() / kMostBlocks + 1;
  std::array<Strength, 3> out;
  for (int c = 0; !planes.empty() && c < planes[0].channels(); ++c) {
    std::vector<Sample> samples;
    for (std::size_t i = 0; i < places.size(); i += every) {
      if (samples.size() % 1024 == 0) work.check();
      const auto& [s, x, y] = places[i];
      const Block b = planes[s].block(c, x, y);
      const float lightness = lightness_of(c == 0 ? b : planes[s].block(0, x, y));
      samples.push_back({b, energy_of(b), level_of(lightness)});
    }
    work.check();
    out[c] = strength_of(samples);
  }
  return out;
}

}  // namespace terrazzo::detail_solid
