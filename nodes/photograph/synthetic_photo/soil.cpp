#include "nodes/photograph/synthetic_photo/soil.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/noise.h"

namespace terrazzo::synthetic_photo {
namespace {

// Octaves of noise from the largest hills to crumbs, plain or with ridges like clods that broke apart.
class Ground {
 public:
  Ground(Random& r, double side)
      : seed_(r.bits()),
        size_(side * r.uniform(0.3, 1.2)),
        height_(r.uniform(0.1, 1) * r.uniform(0.02, 0.3) * size_),
        rough_(r.uniform(0.35, 0.75)),
        ridged_(r.uniform() < 0.35 ? r.uniform(0.2, 1) : 0),
        ledges_(r.uniform() < 0.25 ? r.uniform(4, 30) : 0),
        ledge_size_(side * r.uniform(0.1, 0.5)) {}

  // Octaves above and below a wavelength of `split` canvas pixels.
  double coarse(const Vec3& p, double split) const {
    double sum = ledges_ > 0 ? ledge(p) : 0;
    return sum + octaves(p, split, true);
  }
  double fine(const Vec3& p, double split) const { return octaves(p, split, false); }

 private:
  double octaves(const Vec3& p, double split, bool above) const {
    double sum = 0, size = size_, height = height_;
    for (int k = 0; k < 9 && size > 4; ++k, size /= 2, height *= rough_) {
      if ((size >= split) != above) continue;
      const double n = noise(seed_ + k, p / size);
      sum += height * ((1 - ridged_) * n + ridged_ * (0.5 - 2 * std::abs(n)));
    }
    return sum;
  }
  // Layers of a bank that weather differently.
  double ledge(const Vec3& p) const {
    const double t = p.y() / ledge_size_ + 0.6 * turbulence(seed_ + 50, p / (2 * ledge_size_), 2);
    const double f = t - std::floor(t);
    return ledges_ * (f < 0.75 ? f / 0.75 : (1 - f) / 0.25);
  }
  std::uint64_t seed_;
  double size_, height_, rough_, ridged_, ledges_, ledge_size_;
};

// Branching cracks, longer than high: level lines of noise, open in places only.
class Cracks {
 public:
  Cracks(Random& r, double side)
      : seed_(r.bits()),
        depth_(r.uniform() < 0.15 ? r.uniform(4, 30) : 0),
        size_(side * r.uniform(0.08, 0.4)),
        stretch_(r.uniform(1, 3)),
        width_(r.uniform(0.015, 0.06)),
        open_(r.uniform(-0.1, 0.25)) {}
  bool any() const { return depth_ > 0; }
  double depth(const Vec3& p) const {
    const Vec3 q(p.x() / (size_ * stretch_), p.y() / size_, 0);
    if (noise(seed_ + 5, q * 0.7) < open_) return 0;
    const double d = std::abs(turbulence(seed_, q, 3)) / width_;
    return d < 1 ? depth_ * (1 - d * d) : 0;
  }

 private:
  std::uint64_t seed_;
  double depth_, size_, stretch_, width_, open_;
};

// Grains of sand that touch: a mosaic of cells, each a small bump with a color of its own.
class Sand {
 public:
  Sand(const PhotoPalette& palette, Random& r)
      : seed_(r.bits()),
        size_(std::exp(r.uniform(std::log(2.5), std::log(11.0)))),
        relief_(size_ * r.uniform(0.05, 0.45)),
        contrast_(r.uniform(0.05, 0.6)),
        cover_(r.uniform() < 0.4 ? r.uniform(0.2, 0.9) : 1) {
    for (Vec3f& color : tints_) color = palette.particle(r, size_).color;
    tinted_ = r.uniform() < 0.5 ? r.uniform(0, 0.7) : 0;
    strength_ = r.uniform(0.1, 0.9);
  }
  // Raises the surface and changes its color; `share` of the effect.
  void add(const Vec3& p, float share, float& z, Vec3f& color) const {
    const Cell cell = cellular(seed_, p / size_);
    const double kind = 7.31 * cell.shade - std::floor(7.31 * cell.shade),
                 there = 13.7 * cell.shade - std::floor(13.7 * cell.shade);
    if (there > cover_) return;
    const double dome = std::min(1.0, 2.5 * cell.edge);
    z += static_cast<float>(share * relief_ * (dome * (2 - dome) + 1.5 * cell.shade));
    if (kind < tinted_) {
      const Vec3f& tint = tints_[kind / tinted_ * 2.999];
      color += share * strength_ * (tint - color);
    }
    color *= static_cast<float>(std::exp(share * contrast_ * (2 * cell.shade - 1)));
  }

 private:
  std::uint64_t seed_;
  double size_, relief_, contrast_, cover_, tinted_ = 0;
  float strength_ = 0;
  std::array<Vec3f, 3> tints_;
};

// A smooth field seen through every fourth point.
class Field {
 public:
  static constexpr int kStep = 4;
  Field(const Canvas& c)
      : columns_(c.width / kStep + 2), rows_(c.height / kStep + 2), values_(columns_ * rows_) {}
  template <class Value>
  void fill(const Value& value) {
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < columns_; ++x)
        values_[y * columns_ + x] = static_cast<float>(value(Vec3(x * kStep, y * kStep, 0)));
  }
  float operator()(int x, int y) const {
    const int k = y / kStep * columns_ + x / kStep;
    const float u = static_cast<float>(x % kStep) / kStep, v = static_cast<float>(y % kStep) / kStep;
    return (1 - v) * ((1 - u) * values_[k] + u * values_[k + 1]) +
           v * ((1 - u) * values_[k + columns_] + u * values_[k + columns_ + 1]);
  }

 private:
  int columns_, rows_;
  std::vector<float> values_;
};

// Hollows: ragged pits, and the smooth molds of stones that fell out.
void dig(Canvas& c, Random& r) {
  for (int pits = static_cast<int>(r.below(12)) - 4; pits > 0; --pits) {
    const bool mold = r.uniform() < 0.4;
    const double px = r.uniform(0, c.width), py = r.uniform(0, c.height), size = r.uniform(6, mold ? 90 : 70),
                 depth = size * r.uniform(0.2, mold ? 0.7 : 1.8), ragged = mold ? 0.12 : 0.7;
    const std::uint64_t s = r.bits();
    for (int y = std::max<int>(0, py - 2 * size); y < std::min<double>(c.height, py + 2 * size); ++y)
      for (int x = std::max<int>(0, px - 2 * size); x < std::min<double>(c.width, px + 2 * size); ++x) {
        const double d = std::hypot(x - px, y - py) / size + ragged * turbulence(s, Vec3(x, y, 0) / size, 2);
        if (d < 1) c.z[c.at(x, y)] -= static_cast<float>(depth * std::sqrt(std::max(0.0, 1 - d * d)));
      }
  }
}

// Fine gravel without labels: without it a network marks every grain of sand.
void scatter_gravel(Canvas& c, const Field& smooth, const PhotoPalette& palette, Random& r,
                    const Work& work) {
  for (int layers = r.below(4); layers > 0; --layers) {
    const double largest = r.uniform(2, 7), cover = r.uniform(0.02, 0.6), area = c.width * c.height;
    const double contrast = r.uniform(0.1, 1);
    for (double covered = 0; covered < cover * area;) {
      work.check();
      const double radius = largest * (0.35 + 0.65 * r.uniform() * r.uniform());
      const double px = r.uniform(0, c.width), py = r.uniform(0, c.height), flat = r.uniform(0.5, 1);
      Vec3f color = palette.particle(r, radius).color;
      color = palette.ground_color() + static_cast<float>(contrast) * (color - palette.ground_color());
      covered += 3.14 * radius * radius;
      const int reach = static_cast<int>(radius) + 1;
      const int cx = static_cast<int>(px), cy = static_cast<int>(py);
      const float base = c.z[c.at(cx, cy)] - static_cast<float>(radius * flat * r.uniform(0, 0.7));
      if (smooth(cx, cy) > 0.5f) continue;
      for (int y = std::max(0, cy - reach); y <= std::min(c.height - 1, cy + reach); ++y)
        for (int x = std::max(0, cx - reach); x <= std::min(c.width - 1, cx + reach); ++x) {
          const double d2 = ((x - px) * (x - px) + (y - py) * (y - py)) / (radius * radius);
          if (d2 >= 1) continue;
          const float z = base + static_cast<float>(radius * flat * std::sqrt(1 - d2));
          const std::size_t i = c.at(x, y);
          if (z > c.z[i] && c.id[i] == 0) {
            c.z[i] = z;
            c.color[i] = color;
          }
        }
    }
  }
}

}  // namespace

void make_soil(Canvas& c, const PhotoPalette& palette, Random& r, const Work& work) {
  const double side = std::sqrt(static_cast<double>(c.width) * c.height);
  const Texture rough = palette.ground(r), even = palette.clay(r);
  const Ground ground(r, side);
  const Cracks cracks(r, side);
  const double grain = r.uniform(0, 2.2), grain_size = r.uniform(2, 6);
  const double shaded = r.uniform(0, 0.4), damp = r.uniform() < 0.5 ? r.uniform(0, 0.5) : 0,
               damp_size = r.uniform(40, 300);
  const double even_size = r.uniform(40, 300), even_share = r.uniform() < 0.2 ? r.uniform(-0.3, 0.4) : -9;
  const std::uint64_t seed = r.bits();
  std::vector<Sand> sands;
  for (int kinds = r.uniform() < 0.25 ? 0 : 1 + static_cast<int>(r.below(2)); kinds > 0; --kinds)
    sands.emplace_back(palette, r);
  constexpr double kSplit = 24;  // the larger octaves are smooth
  Field hills(c), wet(c), smooth(c);
  hills.fill([&](const Vec3& p) { return ground.coarse(p, kSplit); });
  wet.fill([&](const Vec3& p) {
    return 1 - damp * std::clamp(0.5 + 2 * turbulence(seed + 3, p / damp_size, 3), 0.0, 1.0);
  });
  smooth.fill([&](const Vec3& p) {
    return std::clamp(0.5 + 6 * (even_share + turbulence(seed + 5, p / even_size, 3)), 0.0, 1.0);
  });
  for (int y = 0; y < c.height; ++y) {
    work.check();
    for (int x = 0; x < c.width; ++x) {
      const Vec3 p(x, y, 0);
      const std::size_t i = c.at(x, y);
      const float s = smooth(x, y);
      const double crumbs = (1 - 0.9 * s) * noise(seed + 9, p / grain_size);
      c.z[i] = hills(x, y) + static_cast<float>((1 - 0.85 * s) * ground.fine(p, kSplit) + grain * crumbs);
      if (cracks.any()) c.z[i] -= static_cast<float>(cracks.depth(p));
      Vec3f color = rough(p);
      if (s > 0) color += s * (even(p) - color);
      for (const Sand& sand : sands) sand.add(p, 1 - 0.9f * s, c.z[i], color);
      c.color[i] = color * wet(x, y) * static_cast<float>(std::max(0.2, 1 + shaded * crumbs));
    }
  }
  dig(c, r);
  scatter_gravel(c, smooth, palette, r, work);
}

void spread_clay(Canvas& c, const PhotoPalette& palette, Random& r, const Work& work) {
  const Texture texture = palette.clay(r);
  const double sigma = r.uniform(6, 40), waves = sigma * r.uniform(0.1, 0.8),
               size = sigma * r.uniform(1.5, 5);
  const double crumbs = r.uniform() < 0.5 ? 0 : r.uniform(0, 1.5), crumb_size = r.uniform(2, 6);
  const std::uint64_t seed = r.bits();
  std::vector<float> level = c.z;
  blur(level, c.width, c.height, sigma);
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const Vec3 p(x, y, 0);
      level[c.at(x, y)] += static_cast<float>(waves * turbulence(seed, p / size, 3) +
                                              (crumbs > 0 ? crumbs * noise(seed + 9, p / crumb_size) : 0));
    }
  work.check();
  // The share of the picture that is covered decides how high the clay stands.
  std::vector<float> above(level.size());
  for (std::size_t i = 0; i < above.size(); ++i) above[i] = level[i] - c.z[i];
  std::vector<float> sorted = above;
  const float drop = at_rank(sorted, static_cast<std::size_t>(sorted.size() * r.uniform(0.5, 0.97)));
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const std::size_t i = c.at(x, y);
      const float over = above[i] - drop;
      if (over <= 0) continue;
      c.z[i] = level[i] - drop;
      c.id[i] = 0;
      c.gloss[i] = 0;
      // A film shows what is below.
      const float t = std::min(1.0f, over / 1.5f);
      c.color[i] += t * (texture(Vec3(x, y, 0)) - c.color[i]);
    }
}

}  // namespace terrazzo::synthetic_photo
