#include "nodes/bodies/view/painter.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "nodes/bodies/view/exposure.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::view {
namespace {

constexpr std::uint64_t kSkyStream = 0x736b7921;
constexpr std::size_t kRows = 4;  // of a range for one thread
constexpr int kSkyReach = 2;      // pixels over which the sky is smoothed

}  // namespace

Painter::Painter(const Bed& bed, const Shader& shader, const carving::ParticleColors& colors,
                 const SurfaceOptions& options, float albedo, int picture)
    : bed_(bed), shader_(shader), colors_(colors), options_(options), albedo_(albedo) {
  const std::size_t pixels = pixels_in(options.pixels_x, options.pixels_y);
  first_ = picture * pixels;
  stone_.assign(pixels, -1);
  height_.assign(pixels, 0.0f);
  color_.assign(pixels, Vec3f::Zero());
  sun_.assign(pixels, 0.0f);
  sky_.assign(pixels, 0.0f);
}

void Painter::each_row(const Work& work, const std::function<void(int)>& use) const {
  work.parallel(options_.pixels_y, kRows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      work.check();
      use(static_cast<int>(row));
    }
  });
}

void Painter::paint(Vec3f* pixels, const Work& work) {
  const float deepest = -static_cast<float>(bed_.depth());
  ground_ = options_.area_fraction ? ground_level(work.part(0, 0.05)) : deepest;
  soil_ = options_.loose ? deepest : ground_;
  if (options_.shaded)
    paint_lit(pixels, work);
  else
    paint_flat(pixels, work.part(0.05, 1));
  hide_ground();
}

void Painter::paint_flat(Vec3f* pixels, const Work& work) {
  each_row(work, [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) {
      color_pixel(x, row);
      pixels[at(x, row)] = color_[at(x, row)].cwiseMax(0.0f).cwiseMin(1.0f);
    }
  });
}

void Painter::paint_lit(Vec3f* pixels, const Work& work) {
  each_row(work.part(0.05, 0.8), [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) light_pixel(x, row);
  });
  std::vector<float> open(sky_.size());
  each_row(work.part(0.8, 0.85), [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) open[at(x, row)] = smooth_sky(x, row);
  });
  color_ = exposed({stone_, height_, color_, sun_, open, ground_, options_.pixels_x, albedo_,
                    colors_.at(Vec3f::Zero(), -1, false)},
                   options_, work);
  each_row(work.part(0.85, 1), [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) pixels[at(x, row)] = antialiased(x, row);
  });
}

BedPoint Painter::seen(float x, float row) const {
  BedPoint point;
  if (bed_.below(across(x), upwards(row), point) && point.at.z() > soil_) return point;
  BedPoint soil;
  soil.at = Vec3f(across(x), upwards(row), soil_);
  return soil;
}

void Painter::hide_ground() {
  for (std::size_t i = 0; i < stone_.size(); ++i)
    if (height_[i] <= ground_) stone_[i] = -1;
}

// A quantile of the heights at pixel centers.
float Painter::ground_level(const Work& work) const {
  const float deepest = -static_cast<float>(bed_.depth());
  std::vector<float> heights(stone_.size(), deepest);
  each_row(work, [&](int row) {
    BedPoint point;
    for (int x = 0; x < options_.pixels_x; ++x)
      if (bed_.below(across(x + 0.5f), upwards(row + 0.5f), point))
        heights[at(x, row)] = std::max(deepest, point.at.z());
  });
  const std::size_t covered = std::llround(*options_.area_fraction * heights.size());
  if (covered >= heights.size()) return deepest;
  const auto highest = heights.begin() + covered;
  std::nth_element(heights.begin(), highest, heights.end(), std::greater<>());
  return *highest;
}

BedPoint Painter::color_pixel(int x, int row) {
  const std::size_t i = at(x, row);
  const BedPoint point = seen(x + 0.5f, row + 0.5f);
  stone_[i] = point.stone;
  height_[i] = point.at.z();
  color_[i] = colors_.at(bed_.in_packing(point), point.stone < 0 ? -1 : bed_.particle(point.stone), true);
  return point;
}

void Painter::light_pixel(int x, int row) {
  const std::size_t i = at(x, row);
  const BedPoint point = color_pixel(x, row);
  sun_[i] = shader_.sun(point);
  sky_[i] = shader_.sky(point, Random(options_.seed, kSkyStream, first_ + i).bits());
}

// Sixteen rays leave noise, which neighbors on the same stone average out.
float Painter::smooth_sky(int x, int row) const {
  const int last_x = std::min(options_.pixels_x - 1, x + kSkyReach);
  const int last_row = std::min(options_.pixels_y - 1, row + kSkyReach);
  const std::int32_t stone = stone_[at(x, row)];
  float sum = 0;
  int count = 0;
  for (int v = std::max(0, row - kSkyReach); v <= last_row; ++v)
    for (int u = std::max(0, x - kSkyReach); u <= last_x; ++u) {
      if (stone_[at(u, v)] != stone) continue;
      sum += sky_[at(u, v)];
      ++count;
    }
  return sum / count;
}

// The color of the stone, or of the soil, in this pixel or the nearest one around it whose center shows it;
// slivers that no center shows take the pixel's own.
Vec3f Painter::color_near(int x, int row, int stone) const {
  constexpr int kNear[9][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  for (const auto& [dx, dy] : kNear) {
    const int u = x + dx;
    const int v = row + dy;
    if (u < 0 || v < 0 || u >= options_.pixels_x || v >= options_.pixels_y) continue;
    if (stone_[at(u, v)] == stone) return color_[at(u, v)];
  }
  return color_[at(x, row)];
}

// Light is smooth within a stone, so only outlines need several rays.
Vec3f Painter::antialiased(int x, int row) const {
  Vec3f sum = Vec3f::Zero();
  for (float v : {0.25f, 0.75f})
    for (float u : {0.25f, 0.75f}) sum += color_near(x, row, seen(x + u, row + v).stone);
  return sum / 4;
}

}  // namespace terrazzo::view
