#include "nodes/detail/detail_solid/noise_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual/camera_noise.h"
#include "nodes/detail/residual/outline_depth.h"

namespace terrazzo::detail_solid {
namespace {

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

}  // namespace

Block Plane::block(int c, int x, int y) const {
  Block b;
  for (int row = 0; row < kBlock; ++row)
    b.row(row) = Eigen::Map<const Eigen::Matrix<float, 1, kBlock>>(&channel[c][pixel_at(x, y + row, width)]);
  return cosines() * b * cosines().transpose();
}

bool Plane::even(int x, int y) const {
  const std::int32_t first = place[pixel_at(x, y, width)];
  for (int row = 0; row < kBlock && first > 0; ++row)
    for (int i = 0; i < kBlock; ++i)
      if (place[pixel_at(x + i, y + row, width)] != first) return false;
  return first > 0;
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
    if (i % kCheckEvery == 0) work.check();
    const Vec3f v = residual::noise_axes() * linear_to_srgb(image.pixels[first + i].cwiseMax(0.0f));
    for (int c = 0; c < p.channels(); ++c) p.channel[c][i] = v[c];
    if (depth[i] > 1 + 2 * softness && !(mask && mask->ids[first + i] != 0))
      p.place[i] = labels.ids[first + i] + 1;
  }
  return p;
}

Block pixels_of(const Block& coefficients) { return cosines().transpose() * coefficients * cosines(); }

float lightness_of(const Block& coefficients) { return coefficients(0, 0) / (kBlock * std::sqrt(3.0f)); }

int level_of(float lightness) {
  const int level = std::clamp(lightness, 0.0f, 1.0f) * kLightness;
  return std::min(level, kLightness - 1);
}

}  // namespace terrazzo::detail_solid
