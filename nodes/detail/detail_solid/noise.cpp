#include "nodes/detail/detail_solid/noise.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual/outline_depth.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kBlock = 16, kApart = 4, kStep = 4;  // pixels: blocks, and their distance in both passes
constexpr int kLevels = 32;                        // of lightness, 0 to 1
constexpr std::size_t kLeastAtLevel = 40, kLeastBlocks = 200, kMostBlocks = 60000;
// How many times further blocks may spread than those of Gaussian noise. That of one camera measures 1.05 to
// 1.3, with the slopes and edges that blocks contain.
constexpr double kEven = 1.6;
// The least share of the noise's power at wavelengths below 8 pixels: 0.74 at a blur of 0.7 pixels.
constexpr double kFine = 0.5;
constexpr float kMostChange = 4;  // of its variance between two levels that are not black or white
constexpr float kLeastDeviation = 0.5f / 255;  // half a step of 8 bits
constexpr float kThreshold = 3.2f;             // of coefficients, in deviations
constexpr std::size_t kCheck = 1 << 20;        // pixels between checks for cancellation
constexpr int kFar = Detail::Noise::kReach;

using Block = Eigen::Matrix<float, kBlock, kBlock, Eigen::RowMajor>;
using Channels = std::array<std::vector<float>, 3>;

// Lightness times √3 and two axes of chroma, orthonormal.
const Eigen::Matrix3f& channel_axes() {
  static const Eigen::Matrix3f axes = [] {
    Eigen::Matrix3f m;
    m.row(0) = Vec3f(1, 1, 1).normalized();
    m.row(1) = Vec3f(1, 0, -1).normalized();
    m.row(2) = Vec3f(1, -2, 1).normalized();
    return m;
  }();
  return axes;
}

// The orthonormal cosine transform of a block: C · B · Cᵀ.
const Block& cosines() {
  static const Block c = [] {
    Block m;
    for (int k = 0; k < kBlock; ++k)
      for (int x = 0; x < kBlock; ++x)
        m(k, x) = std::sqrt((k ? 2.0 : 1.0) / kBlock) * std::cos(std::numbers::pi * (x + 0.5) * k / kBlock);
    return m;
  }();
  return c;
}

// One section of a photograph in channels, and the pixels far enough from outlines.
struct Plane {
  int width = 0, height = 0;
  bool gray = false;
  Channels channel;
  std::vector<std::int32_t> place;  // the label + 1; 0: not used

  int channels() const { return gray ? 1 : 3; }
  Block block(int c, int x, int y) const {
    Block b;
    for (int row = 0; row < kBlock; ++row)
      b.row(row) =
          Eigen::Map<const Eigen::Matrix<float, 1, kBlock>>(&channel[c][pixel_at(x, y + row, width)]);
    return cosines() * b * cosines().transpose();
  }
  // Whether all pixels of a block are used and of one label.
  bool even(int x, int y) const {
    const std::int32_t first = place[pixel_at(x, y, width)];
    for (int row = 0; row < kBlock && first > 0; ++row)
      for (int i = 0; i < kBlock; ++i)
        if (place[pixel_at(x + i, y + row, width)] != first) return false;
    return first > 0;
  }
};

float lightness_of(const Block& coefficients) { return coefficients(0, 0) / (kBlock * std::sqrt(3.0f)); }

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

Plane plane_of(const Image& image, const Labels& labels, const Labels* mask, int section, bool gray,
               double softness, const Work& work) {
  Plane p;
  p.width = image.width;
  p.height = image.height;
  p.gray = gray;
  const std::size_t pixels = pixels_in(p.width, p.height), first = section * pixels;
  for (int c = 0; c < p.channels(); ++c) p.channel[c].resize(pixels);
  p.place.assign(pixels, 0);
  const auto depth = residual::outline_depth(&labels.ids[first], p.width, p.height, false);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (i % kCheck == 0) work.check();
    const Vec3f v = channel_axes() * linear_to_srgb(image.pixels[first + i].cwiseMax(0.0f));
    for (int c = 0; c < p.channels(); ++c) p.channel[c][i] = v[c];
    if (depth[i] > 1 + 2 * softness && !(mask && mask->ids[first + i] != 0))
      p.place[i] = labels.ids[first + i] + 1;
  }
  return p;
}

int level_of(float lightness) {
  return std::min(static_cast<int>(std::clamp(lightness, 0.0f, 1.0f) * kLevels), kLevels - 1);
}

// The noise's variance in each coefficient, by lightness: strength[level] · spectrum.
struct Strength {
  Block spectrum = Block::Zero();
  std::array<float, kLevels> at{};
  bool known = false;
  double uneven = 0, fine = 0, change = 1;

  bool of_a_camera() const { return known && uneven <= kEven && fine >= kFine && change <= kMostChange; }
};

// Levels without a value take those of the nearest ones, between two linearly.
void fill_levels(std::array<float, kLevels>& at, const std::array<bool, kLevels>& known) {
  int last = -1;
  for (int k = 0; k < kLevels; ++k) {
    if (!known[k]) continue;
    for (int i = last + 1; i < k; ++i)
      at[i] = last < 0 ? at[k] : at[last] + (at[k] - at[last]) * float(i - last) / float(k - last);
    last = k;
  }
  for (int i = last + 1; i < kLevels && last >= 0; ++i) at[i] = at[last];
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

// `samples`: blocks of one channel.
Strength strength_of(const std::vector<Sample>& samples) {
  Strength out;
  std::array<std::vector<float>, kLevels> energies;
  for (const Sample& s : samples) energies[s.level].push_back(s.energy);
  std::array<bool, kLevels> known{};
  std::array<float, kLevels> low{}, middle{}, quarter{};
  for (int k = 0; k < kLevels; ++k) {
    if (energies[k].size() < kLeastAtLevel) continue;
    low[k] = at_rank(energies[k], energies[k].size() / 10);
    quarter[k] = at_rank(energies[k], energies[k].size() / 4);
    middle[k] = at_rank(energies[k], energies[k].size() / 2);
    known[k] = low[k] > 1e-9f;
  }
  double count = 0;
  for (const Sample& s : samples)
    if (known[s.level] && s.energy > low[s.level] && s.energy < middle[s.level]) {
      out.spectrum += s.coefficients.cwiseAbs2() / s.energy;
      ++count;
    }
  if (count < kLeastBlocks) return out;
  out.spectrum /= static_cast<float>(count);
  double sum = 0, squares = 0;
  for (int v = 0; v < kBlock; ++v)
    for (int u = 0; u < kBlock; ++u)
      if (u + v >= 3) {
        sum += out.spectrum(v, u);
        squares += out.spectrum(v, u) * out.spectrum(v, u);
      }
  // Energies of Gaussian noise follow about a χ² distribution.
  const double spread = std::sqrt(2 * squares) / sum;
  constexpr double kTenth = 1.2816, kQuarter = 0.6745;  // quantiles of the normal distribution
  std::vector<std::pair<double, std::size_t>> uneven;
  std::size_t all = 0, below = 0;
  for (int k = 0; k < kLevels; ++k) {
    if (!known[k]) continue;
    uneven.emplace_back(std::log(middle[k] / low[k]) / (kTenth * spread), energies[k].size());
    all += energies[k].size();
    out.at[k] = quarter[k] * static_cast<float>(std::exp(kQuarter * spread));
  }
  std::sort(uneven.begin(), uneven.end());
  for (const auto& [value, blocks] : uneven) {
    out.uneven = value;
    if (2 * (below += blocks) >= all) break;
  }
  float least = 0, most = 0;
  for (int k = 1; k + 1 < kLevels; ++k) {  // black and white cut noise off
    if (!known[k] || 20 * energies[k].size() < all) continue;
    least = least > 0 ? std::min(least, out.at[k]) : out.at[k];
    most = std::max(most, out.at[k]);
  }
  if (least > 0) out.change = most / least;
  fill_levels(out.at, known);
  out.fine = fine_share(out.spectrum);
  limit_coarse(out.spectrum);
  out.known = true;
  return out;
}

// Of each channel. Blocks are thinned out evenly.
std::array<Strength, 3> strengths_of(const std::vector<Plane>& planes, const Work& work) {
  std::vector<std::array<int, 3>> places;
  for (std::size_t s = 0; s < planes.size(); ++s) {
    work.check();
    for (int y = 0; y + kBlock <= planes[s].height; y += kApart) {
      work.check();
      for (int x = 0; x + kBlock <= planes[s].width; x += kApart)
        if (planes[s].even(x, y)) places.push_back({static_cast<int>(s), x, y});
    }
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
    out[c].known = out[c].of_a_camera();
  }
  return out;
}

// Sets the small coefficients of a block to zero. Returns how many are left, with the mean.
int shrink(Block& coefficients, const Block& least_square) {
  int kept = 1;
  for (int k = 1; k < kBlock * kBlock; ++k) {
    float& v = coefficients.data()[k];
    if (v * v < least_square.data()[k]) v = 0;
    kept += v != 0;
  }
  return kept;
}

// Where blocks lie: kStep apart, the last ones at the edges.
struct BlockGrid {
  explicit BlockGrid(const Plane& p)
      : columns((p.width - kBlock) / kStep + 1),
        rows((p.height - kBlock) / kStep + 1),
        right(p.width - kBlock),
        bottom(p.height - kBlock) {}
  int x(int column) const { return column + 1 < columns ? column * kStep : right; }
  int y(int row) const { return row + 1 < rows ? row * kStep : bottom; }
  int columns, rows, right, bottom;
};

// Takes the noise out of each channel: a pixel becomes the mean of all blocks that show it, after their small
// coefficients are set to zero; blocks that need few coefficients count more.
void remove_noise(Plane& p, const std::array<Strength, 3>& strength, const Work& work) {
  const BlockGrid grid(p);
  constexpr int kRows = 16;  // of blocks, a band; bands two apart show different pixels
  const std::size_t bands = (grid.rows + kRows - 1) / kRows;
  std::vector<std::uint8_t> level(pixels_in(grid.columns, grid.rows));
  for (int c = 0; c < p.channels(); ++c) {
    if (!strength[c].known) continue;
    std::vector<float> sum(p.place.size(), 0), weight(p.place.size(), 0);
    const auto add_band = [&](std::size_t band) {
      const int from = static_cast<int>(band) * kRows, to = std::min(grid.rows, from + kRows);
      for (int row = from; row < to; ++row) {
        work.check();
        for (int column = 0; column < grid.columns; ++column) {
          const int x = grid.x(column), y = grid.y(row);
          Block b = p.block(c, x, y);
          std::uint8_t& l = level[pixel_at(column, row, grid.columns)];
          if (c == 0) l = static_cast<std::uint8_t>(level_of(lightness_of(b)));
          const Block least = kThreshold * kThreshold * strength[c].at[l] * strength[c].spectrum;
          const float share = 1.0f / static_cast<float>(shrink(b, least));
          const Block clean = cosines().transpose() * b * cosines();
          for (int j = 0; j < kBlock; ++j)
            for (int i = 0; i < kBlock; ++i) {
              sum[pixel_at(x + i, y + j, p.width)] += share * clean(j, i);
              weight[pixel_at(x + i, y + j, p.width)] += share;
            }
        }
      }
    };
    for (const std::size_t first : {0, 1})
      work.parallel((bands + 1 - first) / 2, 1, [&](std::size_t k, std::size_t) { add_band(2 * k + first); });
    for (std::size_t i = 0; i < sum.size(); ++i) {
      if (i % kCheck == 0) work.check();
      p.channel[c][i] = sum[i] / weight[i];
    }
  }
}

// Deviations of the noise by lightness. `noise`: what was removed from the planes.
std::vector<float> deviations_of(const std::vector<Plane>& clean, const std::vector<Channels>& noise,
                                 int from, int to, const Work& work) {
  std::array<float, kLevels> at{};
  std::array<bool, kLevels> known{};
  for (int c = from; c < to; ++c) {
    std::array<std::vector<float>, kLevels> size;
    for (std::size_t s = 0; s < clean.size(); ++s)
      for (std::size_t i = 0; i < clean[s].place.size(); ++i) {
        if (i % kCheck == 0) work.check();
        if (clean[s].place[i] > 0)
          size[level_of(clean[s].channel[0][i] / std::sqrt(3.0f))].push_back(std::abs(noise[s][c][i]));
      }
    for (int k = 0; k < kLevels; ++k) {
      known[k] = size[k].size() >= kLeastAtLevel * kBlock * kBlock;
      constexpr float kMedian = 0.6745f;  // of a normal variable's size; faint grain hardly moves it
      if (known[k]) at[k] = std::hypot(at[k], median(std::move(size[k])) / kMedian);
    }
  }
  for (float& d : at) d /= std::sqrt(static_cast<float>(to - from));
  fill_levels(at, known);
  return {at.begin(), at.end()};
}

// The kernel that gives white noise the correlation of what was removed, relative to its deviation.
std::vector<float> kernel_of(const std::vector<Plane>& clean, const std::vector<Channels>& noise,
                             const std::vector<float>& deviation, int from, int to, const Work& work) {
  constexpr int kSide = 2 * kFar + 1;
  std::array<double, kSide * kSide> sum{}, count{};
  const auto limited = [](float v) { return std::clamp(v, -3.0f, 3.0f); };
  for (std::size_t s = 0; s < clean.size(); ++s) {
    const Plane& p = clean[s];
    for (int y = kFar; y + kFar < p.height; y += 2) {
      work.check();
      for (int x = kFar; x + kFar < p.width; x += 2) {
        const std::size_t at = pixel_at(x, y, p.width);
        if (p.place[at] == 0) continue;
        const float d = deviation[level_of(p.channel[0][at] / std::sqrt(3.0f))];
        if (!(d > 0)) continue;
        for (int dy = 0; dy <= kFar; ++dy)
          for (int dx = dy == 0 ? 0 : -kFar; dx <= kFar; ++dx) {
            const std::size_t to_at = pixel_at(x + dx, y + dy, p.width);
            if (p.place[to_at] != p.place[at]) continue;
            const int k = (dy + kFar) * kSide + dx + kFar;
            for (int c = from; c < to; ++c)
              sum[k] += limited(noise[s][c][at] / d) * limited(noise[s][c][to_at] / d);
            count[k] += to - from;
          }
      }
    }
  }
  // The spectrum's root, by a transform of the covariance, which is even. Far apart, it is mostly error, so
  // it fades out over the second half of the reach.
  const auto covariance = [&](int dx, int dy) {
    const int k =
        dy > 0 || (dy == 0 && dx >= 0) ? (dy + kFar) * kSide + dx + kFar : (kFar - dy) * kSide + kFar - dx;
    const double beyond = std::clamp(2 * std::hypot(dx, dy) / (kFar + 1) - 1, 0.0, 1.0);
    const double taper = 0.5 + 0.5 * std::cos(std::numbers::pi * beyond);
    return count[k] > 0 ? taper * sum[k] / count[k] : 0;
  };
  constexpr int kSamples = 4 * kFar;  // of the spectrum, along each axis
  const double turn = 2 * std::numbers::pi / kSamples;
  std::vector<double> root(static_cast<std::size_t>(kSamples) * kSamples);
  for (int v = 0; v < kSamples; ++v)
    for (int u = 0; u < kSamples; ++u) {
      double power = 0;
      for (int dy = -kFar; dy <= kFar; ++dy)
        for (int dx = -kFar; dx <= kFar; ++dx)
          power += covariance(dx, dy) * std::cos(turn * (u * dx + v * dy));
      root[pixel_at(u, v, kSamples)] = std::sqrt(std::max(0.0, power));
    }
  std::vector<float> kernel;
  double squares = 0;
  for (int dy = -kFar; dy <= kFar; ++dy)
    for (int dx = -kFar; dx <= kFar; ++dx) {
      double value = 0;
      for (int v = 0; v < kSamples; ++v)
        for (int u = 0; u < kSamples; ++u)
          value += root[pixel_at(u, v, kSamples)] * std::cos(turn * (u * dx + v * dy));
      kernel.push_back(value);
      squares += value * value;
    }
  for (float& v : kernel) v *= squares > 0 ? 1 / std::sqrt(squares) : 0;
  return kernel;
}

}  // namespace

Detail::Noise split_noise(Image& image, const Labels& labels, const Labels* mask, double softness, bool gray,
                          const Work& work) {
  if (std::min(image.width, image.height) < 2 * kBlock) return {};
  std::vector<Plane> planes;
  for (int s = 0; s < image.sections; ++s) {
    work.check();
    planes.push_back(plane_of(image, labels, mask, s, gray, softness, work));
  }
  const std::array<Strength, 3> strength = strengths_of(planes, work.part(0, 0.2));
  if (!strength[0].known) return {};
  std::vector<Channels> noise;
  for (Plane& p : planes) {
    noise.push_back(p.channel);
    remove_noise(p, strength, work.part(0.2, 0.8).quiet());
    for (int c = 0; c < p.channels(); ++c)
      for (std::size_t i = 0; i < p.place.size(); ++i) noise.back()[c][i] -= p.channel[c][i];
  }
  Detail::Noise out;
  out.gray = deviations_of(planes, noise, 0, 1, work);
  out.gray_kernel = kernel_of(planes, noise, out.gray, 0, 1, work);
  if (strength[1].known || strength[2].known) {
    out.chroma = deviations_of(planes, noise, 1, 3, work);
    out.chroma_kernel = kernel_of(planes, noise, out.chroma, 1, 3, work);
  }
  for (float& d : out.gray) d /= std::sqrt(3.0f);  // of the mean of the channels
  if (*std::max_element(out.gray.begin(), out.gray.end()) < kLeastDeviation) return {};
  const std::size_t pixels = pixels_in(image.width, image.height);
  for (std::size_t s = 0; s < planes.size(); ++s)
    for (std::size_t i = 0; i < pixels; ++i) {
      if (i % kCheck == 0) work.check();
      Vec3f v = Vec3f::Zero();
      for (int c = 0; c < planes[s].channels(); ++c) v[c] = planes[s].channel[c][i];
      image.pixels[s * pixels + i] = srgb_to_linear((channel_axes().transpose() * v).cwiseMax(0.0f));
    }
  return out;
}

}  // namespace terrazzo::detail_solid
