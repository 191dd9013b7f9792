#include "nodes/photograph/segment/outline/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/color/split.h"

namespace terrazzo::segment {
namespace {

constexpr float kLeastSide = 0.002f;

// Pixels within `reach` of the other side, by chessboard distance.
std::vector<std::uint8_t> band(const std::vector<std::uint8_t>& mask, int width, int height, int reach) {
  std::vector<std::uint8_t> out(mask.size(), 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = pixel_at(x, y, width);
      const bool right = x + 1 < width && mask[i] != mask[i + 1],
                 below = y + 1 < height && mask[i] != mask[i + width];
      if (!right && !below) continue;
      for (int v = std::max(0, y - reach + 1); v <= std::min(height - 1, y + reach); ++v)
        for (int u = std::max(0, x - reach + 1); u <= std::min(width - 1, x + reach); ++u)
          out[pixel_at(u, v, width)] = 1;
    }
  return out;
}

// Local mean color of the pixels on one side: sums with a Gaussian's weights of the colors (first three) and
// of the pixels' own weights.
struct SideMean {
  std::vector<Eigen::Vector4f> sums;
  Vec3f at(std::size_t i) const { return sums[i].head<3>() / sums[i][3]; }
  bool known(std::size_t i) const { return sums[i][3] > 1e-6f; }
};

SideMean weighted_mean(const LabImage& image, const std::vector<float>& weights, float sigma,
                       const Work& work) {
  SideMean m;
  m.sums.resize(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    m.sums[i].head<3>() = weights[i] * image.pixels[i];
    m.sums[i][3] = weights[i];
  }
  const cv::Mat sums(image.height, image.width, CV_32FC4, m.sums.data());
  // A wide Gaussian leaves no detail that a reduced picture would lose.
  const int reduced = std::max(1, std::min({static_cast<int>(sigma / 2), image.width, image.height}));
  if (reduced == 1) {
    blur_in_place(sums, sigma, work);
    return m;
  }
  cv::Mat small;
  const cv::Size size(round_up(image.width / float(reduced)), round_up(image.height / float(reduced)));
  cv::resize(sums, small, size, 0, 0, cv::INTER_AREA);
  blur_in_place(small, sigma / static_cast<float>(reduced), work);
  cv::resize(small, sums, sums.size(), 0, 0, cv::INTER_LINEAR);
  return m;
}

// The image's blur mixes the pixels at the outline, and in a thin gap or a small particle all pixels. So
// pixels count more for their side's color the deeper they are, up to a depth of three pixels.
std::vector<float> purity(const std::vector<std::uint8_t>& mask, bool inside,
                          const std::vector<float>& depth2) {
  std::vector<float> w(mask.size(), 0.0f);
  for (std::size_t i = 0; i < w.size(); ++i)
    if ((mask[i] != 0) == inside) w[i] = std::pow(std::min(depth2[i], 9.0f) / 9, 3.0f);
  return w;
}

// The binder is one material: where a gap is too thin to show the binder's color, use that of the nearest
// wider gaps.
SideMean binder_mean(const LabImage& image, const std::vector<float>& pure, const Work& work) {
  SideMean m = weighted_mean(image, pure, 2.5f, work);
  for (const float sigma : {8.0f, 24.0f}) {
    const SideMean wide = weighted_mean(image, pure, sigma, work);
    for (std::size_t i = 0; i < pure.size(); ++i) {
      const float share = std::max(0.0f, 0.1f - m.sums[i][3]);
      m.sums[i] += share * wide.sums[i];
    }
  }
  return m;
}

}  // namespace

float sided(float share, bool inside) {
  return inside ? std::clamp(share, 0.5f + kLeastSide, 1.0f) : std::clamp(share, 0.0f, 0.5f - kLeastSide);
}

std::vector<float> smooth_coverage(const std::vector<std::int32_t>& labels, int width, int height,
                                   const Work& work) {
  LabImage mask{width, height, {}};
  for (const auto l : labels) mask.pixels.push_back(Vec3f::Constant(l != 0 ? 1.0f : 0.0f));
  const LabImage soft = blur(std::move(mask), 0.7f, work);
  std::vector<float> share(labels.size());
  for (std::size_t i = 0; i < share.size(); ++i) share[i] = sided(soft.pixels[i][0], labels[i] != 0);
  return share;
}

std::vector<float> refine_outline(const Mosaic& m, std::vector<std::uint8_t>& particles, const Work& work) {
  // A pixel shared by two colors has their mean in linear light. A gray image is treated as a signal (a
  // micrograph, a scan), which is averaged in its encoded values.
  LabImage light = m.image;
  work.parallel(light.pixels.size(), 1 << 14, [&](std::size_t b, std::size_t e) {
    for (std::size_t i = b; i < e; ++i) {
      light.pixels[i] = linear_of_patch_color(light.pixels[i]);
      if (m.gray) light.pixels[i] = linear_to_srgb(light.pixels[i]);
    }
  });
  // Remove noise by a blur, which preserves the position of the half level of a straight edge. Edge-stopping
  // diffusion does not: it pulls mixed pixels to the side with the closer perceived color.
  const float blurring = m.spread > 0 ? std::min(1.4f * m.noise / m.spread, 1.5f) : 0.0f;
  float noise_left = m.noise;
  if (blurring > 0.3f) {
    light = blur(std::move(light), blurring, work);
    noise_left /= std::max(1.0f, 2 * std::sqrt(std::numbers::pi_v<float>) * blurring);
  }
  std::vector<std::int32_t> sides(particles.size());
  for (std::size_t i = 0; i < sides.size(); ++i) sides[i] = particles[i] ? 2 : 1;
  const auto depth2 = squared_distance(sides, m.width, m.height, false, work);
  const SideMean in = weighted_mean(light, purity(particles, true, depth2), 2.5f, work);
  const SideMean out = binder_mean(light, purity(particles, false, depth2), work);
  const float least = std::max(4 * noise_left, 0.01f);
  const auto near = band(particles, m.width, m.height, 3);
  std::vector<float> share(particles.size());
  std::vector<std::uint8_t> read(particles.size(), 0);
  for (std::size_t i = 0; i < share.size(); ++i) {
    share[i] = particles[i] ? 1.0f : 0.0f;
    if (!near[i] || !in.known(i) || !out.known(i)) continue;
    const Vec3f b = out.at(i), f = in.at(i) - b;
    const auto seen = [&](const Vec3f& c) { return patch_color_of_linear(m.gray ? srgb_to_linear(c) : c); };
    if ((seen(in.at(i)) - seen(b)).norm() < least) continue;
    share[i] = std::clamp((light.pixels[i] - b).dot(f) / f.squaredNorm(), 0.0f, 1.0f);
    read[i] = 1;
  }
  // Only pixels at the outline may change sides, in four rounds, so that noise in the interior makes no
  // holes.
  for (int round = 0; round < 4; ++round) {
    const auto edge = band(particles, m.width, m.height, 1);
    for (std::size_t i = 0; i < share.size(); ++i)
      if (edge[i] && read[i]) particles[i] = share[i] >= 0.5f;
  }
  std::vector<std::int32_t> labels(particles.begin(), particles.end());
  const auto smooth = smooth_coverage(labels, m.width, m.height, work);
  const auto edge = band(particles, m.width, m.height, 1);
  for (std::size_t i = 0; i < share.size(); ++i) {
    if (!edge[i])
      share[i] = particles[i] ? 1.0f : 0.0f;
    else
      share[i] = sided(read[i] ? share[i] : smooth[i], particles[i] != 0);
  }
  return share;
}

}  // namespace terrazzo::segment
