#include "nodes/detail/detail_solid/noise.h"

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
#include "nodes/detail/detail_solid/noise_strength.h"
#include "nodes/detail/residual/camera_noise.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kStep = 4;                       // pixels between blocks
constexpr float kLeastDeviation = 0.5f / 255;  // half a step of 8 bits
constexpr float kThreshold = 3.2f;             // of coefficients, in deviations
constexpr int kFar = Detail::Noise::kReach;

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
    if (!strength[c].of_a_camera) continue;
    std::vector<float> sum(p.place.size(), 0), weight(p.place.size(), 0);
    const auto add_band = [&](std::size_t band) {
      const int from = band * kRows, to = std::min(grid.rows, from + kRows);
      for (int row = from; row < to; ++row) {
        work.check();
        for (int column = 0; column < grid.columns; ++column) {
          const int x = grid.x(column), y = grid.y(row);
          Block b = p.block(c, x, y);
          std::uint8_t& l = level[pixel_at(column, row, grid.columns)];
          if (c == 0) l = level_of(lightness_of(b));
          const Block least = kThreshold * kThreshold * strength[c].at[l] * strength[c].spectrum;
          const float share = 1.0f / shrink(b, least);
          const Block clean = pixels_of(b);
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
      if (i % kCheckEvery == 0) work.check();
      p.channel[c][i] = sum[i] / weight[i];
    }
  }
}

// Deviations of the noise by lightness. `noise`: what was removed from the planes.
std::vector<float> deviations_of(const std::vector<Plane>& clean, const std::vector<Channels>& noise,
                                 int from, int to, const Work& work) {
  std::array<float, kLightness> at{};
  std::array<bool, kLightness> known{};
  for (int c = from; c < to; ++c) {
    std::array<std::vector<float>, kLightness> size;
    for (std::size_t s = 0; s < clean.size(); ++s)
      for (std::size_t i = 0; i < clean[s].place.size(); ++i) {
        if (i % kCheckEvery == 0) work.check();
        if (clean[s].place[i] > 0)
          size[level_of(clean[s].channel[0][i] / std::sqrt(3.0f))].push_back(std::abs(noise[s][c][i]));
      }
    for (int k = 0; k < kLightness; ++k) {
      known[k] = size[k].size() >= kLeastAtLevel * kBlock * kBlock;
      constexpr float kMedian = 0.6745f;  // of a normal variable's size; faint grain hardly moves it
      if (known[k]) at[k] = std::hypot(at[k], median(std::move(size[k])) / kMedian);
    }
  }
  for (float& d : at) d /= std::sqrt(float(to - from));
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
  std::vector<double> root(pixels_in(kSamples, kSamples));
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
  if (!strength[0].of_a_camera) return {};
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
  if (strength[1].of_a_camera || strength[2].of_a_camera) {
    out.chroma = deviations_of(planes, noise, 1, 3, work);
    out.chroma_kernel = kernel_of(planes, noise, out.chroma, 1, 3, work);
  }
  for (float& d : out.gray) d /= std::sqrt(3.0f);  // of the mean of the channels
  if (*std::max_element(out.gray.begin(), out.gray.end()) < kLeastDeviation) return {};
  const std::size_t pixels = pixels_in(image.width, image.height);
  for (std::size_t s = 0; s < planes.size(); ++s)
    for (std::size_t i = 0; i < pixels; ++i) {
      if (i % kCheckEvery == 0) work.check();
      Vec3f v = Vec3f::Zero();
      for (int c = 0; c < planes[s].channels(); ++c) v[c] = planes[s].channel[c][i];
      image.pixels[s * pixels + i] = srgb_to_linear((residual::noise_axes().transpose() * v).cwiseMax(0.0f));
    }
  return out;
}

}  // namespace terrazzo::detail_solid
