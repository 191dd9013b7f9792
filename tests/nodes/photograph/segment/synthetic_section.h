// Images of disks and polygons with exactly known areas.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"
#include "runtime/random.h"

namespace terrazzo::test {

struct Disc {
  double x, y, radius;  // pixels, y down
};

inline const Vec3f binder_light{0.62f, 0.6f, 0.55f};

// Draws antialiased in linear light with 8 × 8 samples per pixel.
inline void draw(Image& image, const Disc& d, const Vec3f& color, int section = 0) {
  const int reach = static_cast<int>(d.radius) + 2;
  for (int y = std::max(0, static_cast<int>(d.y) - reach); y < std::min<int>(image.height, d.y + reach + 1);
       ++y)
    for (int x = std::max(0, static_cast<int>(d.x) - reach); x < std::min<int>(image.width, d.x + reach + 1);
         ++x) {
      int inside = 0;
      for (int s = 0; s < 64; ++s)
        inside += std::hypot(x + (s % 8 + 0.5) / 8 - d.x, y + (s / 8 + 0.5) / 8 - d.y) < d.radius;
      const float a = static_cast<float>(inside) / 64.0f;
      image.at(x, y, section) = (1 - a) * image.at(x, y, section) + a * color;
    }
}

// Random disks with `gap` pixels between them, and off the border unless `cut` is set.
inline std::vector<Disc> scatter(int width, int height, int count, double least, double most,
                                 std::uint64_t seed, double gap = 3, bool cut = false) {
  Random random(seed, 77);
  std::vector<Disc> discs;
  for (int attempt = 0; attempt < 100000 && static_cast<int>(discs.size()) < count; ++attempt) {
    const double r = random.uniform(least, most), margin = cut ? -r : r + 2;
    const Disc d{random.uniform(margin, width - margin), random.uniform(margin, height - margin), r};
    bool free = true;
    for (const auto& o : discs) free = free && std::hypot(o.x - d.x, o.y - d.y) > o.radius + r + gap;
    if (free) discs.push_back(d);
  }
  return discs;
}

inline Vec3f chip_color(std::size_t i) {
  static const Vec3f colors[] = {
      {0.12f, 0.06f, 0.04f}, {0.3f, 0.12f, 0.06f}, {0.05f, 0.1f, 0.22f}, {0.02f, 0.02f, 0.02f}};
  return colors[i % 4];
}

inline Image picture(int width, int height, const std::vector<Disc>& discs, double noise = 0,
                     std::uint64_t seed = 1) {
  Image image(width, height, 1, 1, binder_light);
  for (std::size_t i = 0; i < discs.size(); ++i) draw(image, discs[i], chip_color(i));
  for (std::size_t i = 0; noise > 0 && i < image.pixels.size(); ++i) {
    Random random(seed, 5, i);
    for (int k = 0; k < 3; ++k)
      image.pixels[i][k] =
          std::max(0.0f, image.pixels[i][k] * static_cast<float>(1 + noise * random.normal()));
  }
  return image;
}

}  // namespace terrazzo::test
