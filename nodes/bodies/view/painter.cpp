#include "nodes/bodies/view/painter.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::view {
namespace {

constexpr std::uint64_t kSkyStream = 0x736b7921;
constexpr std::size_t kRows = 4;  // of a range for one thread
constexpr int kSkyReach = 2;      // pixels over which the sky is smoothed
constexpr float kDarkest = 1e-6f;

float median_of(std::vector<float>& values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Light with shadows that are deeper by a power.
float shadowed(float light, float power) { return light < 1 ? std::pow(light, power) : light; }

}  // namespace

Painter::Painter(const Bed& bed, const Shader& shader, const carving::ParticleColors& colors,
                 const SurfaceOptions& options, float bounce, int picture)
    : bed_(bed), shader_(shader), colors_(colors), options_(options), bounce_(bounce) {
  const std::size_t pixels = pixels_in(options.pixels_x, options.pixels_y);
  first_ = picture * pixels;
  stone_.assign(pixels, -1);
  height_.assign(pixels, 0.0f);
  color_.assign(pixels, Vec3f::Zero());
  light_.assign(pixels, 0.0f);
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
  const float share = static_cast<float>(options_.light.share);
  each_row(work.part(0.8, 0.85), [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) {
      const float open = smooth_sky(x, row);
      float& light = light_[at(x, row)];
      light = share * light + (1 - share) * open + bounce_ * (1 - open);
    }
  });
  expose(work);
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
  light_[i] = shader_.sun(point);
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

// Multiplies colors by the light, in units of the usual light on stones and on soil.
void Painter::expose(const Work& work) {
  std::vector<float> on_stones;
  double on_soil = 0;
  std::size_t soil_pixels = 0;
  for (std::size_t i = 0; i < light_.size(); ++i) {
    if (stone_[i] < 0) {
      on_soil += light_[i];
      ++soil_pixels;
    } else if (height_[i] > ground_) {
      on_stones.push_back(light_[i]);
    }
  }
  work.check();
  const float stone_light = on_stones.empty() ? 1 : std::max(kDarkest, median_of(on_stones));
  const float soil_light =
      soil_pixels == 0 ? 1 : std::max(kDarkest, static_cast<float>(on_soil / soil_pixels));
  for (std::size_t i = 0; i < light_.size(); ++i) light_[i] /= stone_[i] < 0 ? soil_light : stone_light;
  work.check();
  const float depth = options_.loose ? depth_of_shadows() : 1;
  for (std::size_t i = 0; i < light_.size(); ++i) color_[i] *= shadowed(light_[i], depth);
  const float brightness = options_.brightness ? brightness_for(*options_.brightness) : 1;
  for (std::size_t i = 0; i < color_.size(); ++i)  // soil has the color that was measured
    color_[i] = ((stone_[i] < 0 ? 1 : brightness) * color_[i]).cwiseMax(0.0f).cwiseMin(1.0f);
}

// The factor that makes stones as bright on average as in the photograph. The colors of particles are medians
// over stones of which each has light and shade.
float Painter::brightness_for(float wanted) const {
  double sum = 0;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < color_.size(); ++i) {
    if (stone_[i] < 0 || height_[i] <= ground_) continue;
    sum += color_[i].mean();
    ++pixels;
  }
  return sum > 0 ? static_cast<float>(wanted * pixels / sum) : 1;
}

// The power of the light in shadows at which the places between loose stones are as dark, on average, as in
// the photograph, whose binder they are. Light that is reflected often has a color and a strength that
// sixteen rays don't know.
float Painter::depth_of_shadows() const {
  constexpr float kMost = 2;
  constexpr int kHalvings = 12;
  const float wanted = colors_.at(Vec3f::Zero(), -1, false).mean();
  const auto darkness = [&](float power) {
    double sum = 0;
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < light_.size(); ++i) {
      if (height_[i] > ground_) continue;
      sum += color_[i].mean() * shadowed(light_[i], power);
      ++pixels;
    }
    return pixels == 0 ? wanted : static_cast<float>(sum / pixels);
  };
  if (darkness(1) <= wanted) return 1;
  float low = 1, high = kMost;
  for (int k = 0; k < kHalvings; ++k) {
    const float middle = (low + high) / 2;
    (darkness(middle) > wanted ? low : high) = middle;
  }
  return high;
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
