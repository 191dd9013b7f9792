#include "nodes/photograph/segment/color/mosaic.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/photograph/segment/color/region_graph.h"
#include "nodes/photograph/segment/color/watershed.h"

namespace terrazzo::segment {
namespace {

constexpr float kChroma = 2;

float spread_of(const LabImage& image) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares = 0;
  for (const auto& p : image.pixels) {
    sum += p.cast<double>();
    squares += p.cast<double>().squaredNorm();
  }
  const double n = image.pixels.size();
  return std::sqrt(std::max(0.0, squares / n - (sum / n).squaredNorm()));
}

// Usual color difference of pixels four apart, a measure of noise and texture. It uses the lower quartile,
// since in an image of many small particles half of the pairs have an edge between them. The factor 2.4
// converts it to the median of noise and texture alone (2.1 for normal noise in one channel, less for three
// channels, more if texture is patchy).
float usual_difference(const LabImage& image) {
  constexpr int kApart = 4;
  std::vector<float> all;
  for (int y = 0; y < image.height; y += 2)
    for (int x = 0; x < image.width; x += 2) {
      const Vec3f& p = image.pixels[image.index(x, y)];
      if (x + kApart < image.width) all.push_back((p - image.pixels[image.index(x + kApart, y)]).norm());
      if (y + kApart < image.height) all.push_back((p - image.pixels[image.index(x, y + kApart)]).norm());
    }
  return all.empty() ? 0 : 2.4f * at_rank(all, all.size() / 4);
}

}  // namespace

std::vector<float> gradient_of(const LabImage& image) {
  std::vector<float> g(image.pixels.size());
  for (int y = 0; y < image.height; ++y) {
    const int up = std::max(y - 1, 0), down = std::min(y + 1, image.height - 1);
    for (int x = 0; x < image.width; ++x) {
      const int left = std::max(x - 1, 0), right = std::min(x + 1, image.width - 1);
      const Vec3f dx = image.pixels[image.index(right, y)] - image.pixels[image.index(left, y)];
      const Vec3f dy = image.pixels[image.index(x, down)] - image.pixels[image.index(x, up)];
      g[image.index(x, y)] = 0.5f * std::sqrt(dx.squaredNorm() + dy.squaredNorm());
    }
  }
  return g;
}

Vec3f patch_color(const Vec3f& oklab) { return {oklab[0], kChroma * oklab[1], kChroma * oklab[2]}; }
Vec3f linear_of_patch_color(const Vec3f& c) {
  return oklab_to_linear({c[0], c[1] / kChroma, c[2] / kChroma});
}
Vec3f patch_color_of_linear(const Vec3f& linear) { return patch_color(linear_to_oklab(linear)); }

LabImage patch_section(const Image& image, int section, const Work& work) {
  LabImage out = lab_section(image, section, work);
  for (auto& p : out.pixels) p = patch_color(p);
  return out;
}

void make_patches(Mosaic& m, const Work& work) {
  m.colors.clear();
  m.areas.clear();
  const std::vector<float> gradient = gradient_of(m.smooth);
  const auto basins = watershed(gradient, m.width, m.height, work);
  std::vector<float> weights(gradient.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const float q = gradient[i] / 0.03f;
    weights[i] = 1 / (1 + q * q);
  }
  RegionGraph graph(m.smooth, basins, weights);
  m.contrast = std::max(usual_difference(m.smooth), 0.001f);
  graph.merge(9.0 * m.contrast * m.contrast, work);
  m.patches = graph.labels();
  for (const auto& r : graph.regions()) {
    m.colors.push_back(r.color());
    m.areas.push_back(r.area);
  }
}

Mosaic make_mosaic(const Image& source, int section, const Work& work) {
  Mosaic m;
  m.width = source.width;
  m.height = source.height;
  m.image = lab_section(source, section, work);
  m.noise = noise_of(m.image);
  m.gray = std::all_of(m.image.pixels.begin(), m.image.pixels.end(),
                       [](const Vec3f& p) { return std::abs(p[1]) < 1e-3f && std::abs(p[2]) < 1e-3f; });
  for (auto& p : m.image.pixels) p = patch_color(p);
  m.spread = spread_of(m.image);
  // If noise or fine texture is nearly as strong as the image's contrast, blur it first, so that edges can be
  // recognized.
  const float blurring = m.spread > 0 ? std::clamp(3 * m.noise / m.spread, 0.0f, 2.0f) : 0.0f;
  if (blurring < 0.7f) {
    m.smooth = diffuse(m.image, std::max(3 * m.noise, 0.01f), 20, work.part(0, 0.5));
  } else {
    const float left = m.noise / (2 * std::sqrt(std::numbers::pi_v<float>) * blurring);
    m.smooth = diffuse(blur(m.image, blurring, work), std::max(3 * left, 0.002f), 20, work.part(0, 0.5));
  }

  make_patches(m, work);
  return m;
}

}  // namespace terrazzo::segment
