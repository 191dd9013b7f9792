#include "nodes/bodies/view/painter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <span>

#include "nodes/bodies/view/exposure.h"
#include "nodes/bodies/view/softness.h"
#include "nodes/bodies/view/tones.h"
#include "nodes/data/indices.h"
#include "nodes/data/luminance.h"
#include "runtime/random.h"

namespace terrazzo::view {
namespace {

constexpr std::uint64_t kSkyStream = 0x736b7921;
constexpr std::size_t kRows = 4;  // of a range for one thread
constexpr int kSmooth = 1;        // pixels over which light is smoothed

// Gaussian blur by a large deviation, pixels: of a reduced copy, since its effort grows with the deviation.
cv::Mat blurred_widely(const cv::Mat& values, double deviation) {
  constexpr double kFine = 4;  // reduced pixels
  const double sigma = std::clamp(deviation, 1.0, double(std::max(values.cols, values.rows)));
  const double reduce = std::max(1.0, sigma / kFine);
  const cv::Size size(std::max(1, round_nearest(values.cols / reduce)),
                      std::max(1, round_nearest(values.rows / reduce)));
  cv::Mat out;
  cv::resize(values, out, size, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(out, out, {0, 0}, sigma / reduce, 0, cv::BORDER_REFLECT);
  cv::resize(out, out, values.size(), 0, 0, cv::INTER_LINEAR);
  return out;
}

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
  const std::vector<float> heights = heights_of_stones(work.part(0, 0.05));
  const float level = ground_level(heights);
  ground_ = options_.loose ? level : deepest;
  soil_ = options_.loose ? deepest : level;
  if (soil_ > deepest) {
    raise_soil(work.part(0.05, 0.1));
    soil_ = ground_level(heights);
  }
  if (options_.shaded)
    paint_lit(pixels, work);
  else
    paint_flat(pixels, work.part(0.1, 1));
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
  each_row(work.part(0.1, 0.8), [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) light_pixel(x, row);
  });
  const std::vector<float> sun = smooth(sun_, work.part(0.8, 0.82));
  const std::vector<float> sky = smooth(sky_, work.part(0.82, 0.85));
  const std::vector<float> light =
      exposure({stone_, height_, color_, sun, sky, ground_, options_.pixels_x, albedo_}, options_, work);
  for (std::size_t i = 0; i < color_.size(); ++i) color_[i] *= light[i];
  each_row(work.part(0.85, 1), [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) pixels[at(x, row)] = antialiased(x, row);
  });
  soften_outlines(pixels, stone_, options_.pixels_x, options_.pixels_y,
                  options_.softness / options_.pixel_size);
  const std::span<Vec3f> picture(pixels, color_.size());
  match_tones(picture, options_.tones);  // last, as a camera's exposure
  for (Vec3f& color : picture) color = color.cwiseMax(0.0F).cwiseMin(1.0F);
}

// Soil is uneven: its light grains stand out, as deep ones lie in the shadow, and it rises and falls around
// stones. So it creeps over their edges here and there. Its picture has the light of that already.
void Painter::raise_soil(const Work& work) {
  constexpr float kGrain = 0.7F;   // pixels, standard deviation of the height
  constexpr float kBroad = 0.08F;  // the same of hills, in diameters of the largest stone
  constexpr double kWide = 0.1;    // deviation of their filter, in these diameters
  constexpr float kMost = 2;       // deviations
  cv::Mat bright(options_.pixels_y, options_.pixels_x, CV_32F);
  each_row(work, [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) {
      BedPoint soil;
      soil.at = Vec3f(across(x + 0.5F), upwards(row + 0.5F), soil_);
      bright.at<float>(row, x) = luminance_of(colors_.at(bed_.in_packing(soil), -1, true));
    }
  });
  const auto standardized = [&](const cv::Mat& values) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(values, mean, deviation);
    constexpr double kEven = 1e-3;  // of the mean: soil of one color is level
    if (!(deviation[0] > kEven * mean[0])) return cv::Mat(cv::Mat::zeros(values.size(), CV_32F));
    cv::Mat out = (values - mean[0]) / deviation[0];
    return cv::Mat(cv::min(cv::max(out, -kMost), kMost));
  };
  const double pixel = options_.pixel_size;
  const cv::Mat wide = blurred_widely(bright, kWide * bed_.largest() / pixel);
  const cv::Mat hills = standardized(wide) * (kBroad * bed_.largest());
  const cv::Mat relief = standardized(bright) * (kGrain * pixel) + hills;
  relief_.assign(relief.begin<float>(), relief.end<float>());
}

// Linear between the centers of pixels.
float Painter::soil_at(float x, float row) const {
  if (relief_.empty()) return soil_;
  const float u = std::clamp(x - 0.5F, 0.0F, options_.pixels_x - 1.0F);
  const float v = std::clamp(row - 0.5F, 0.0F, options_.pixels_y - 1.0F);
  const int left = std::min(round_down(u), options_.pixels_x - 1);
  const int upper = std::min(round_down(v), options_.pixels_y - 1);
  const int right = std::min(left + 1, options_.pixels_x - 1);
  const int lower = std::min(upper + 1, options_.pixels_y - 1);
  const auto between = [&](int line) {
    return std::lerp(relief_[at(left, line)], relief_[at(right, line)], u - left);
  };
  return soil_ + std::lerp(between(upper), between(lower), v - upper);
}

BedPoint Painter::seen(float x, float row) const {
  BedPoint point;
  const float ground = soil_at(x, row);
  if (bed_.below(across(x), upwards(row), point) && point.at.z() > ground) return point;
  BedPoint soil;
  soil.at = Vec3f(across(x), upwards(row), ground);
  return soil;
}

void Painter::hide_ground() {
  for (std::size_t i = 0; i < stone_.size(); ++i)
    if (height_[i] <= ground_) stone_[i] = -1;
}

// At pixel centers.
std::vector<float> Painter::heights_of_stones(const Work& work) const {
  const float deepest = -static_cast<float>(bed_.depth());
  std::vector<float> heights(stone_.size(), deepest);
  each_row(work, [&](int row) {
    BedPoint point;
    for (int x = 0; x < options_.pixels_x; ++x)
      if (bed_.below(across(x + 0.5f), upwards(row + 0.5f), point))
        heights[at(x, row)] = std::max(deepest, point.at.z());
  });
  return heights;
}

// A quantile of the heights above the soil's relief. Soil stays at the cut if there are too few stones.
float Painter::ground_level(std::vector<float> heights) const {
  const float deepest = -static_cast<float>(bed_.depth());
  if (!options_.area_fraction) return deepest;
  for (std::size_t i = 0; i < relief_.size(); ++i) heights[i] -= relief_[i];
  const std::size_t covered = std::llround(*options_.area_fraction * heights.size());
  if (covered >= heights.size()) return deepest;
  const auto highest = heights.begin() + covered;
  std::nth_element(heights.begin(), highest, heights.end(), std::greater<>());
  return *highest <= deepest && !options_.loose ? 0 : *highest;
}

BedPoint Painter::color_pixel(int x, int row) {
  const std::size_t i = at(x, row);
  const BedPoint point = seen(x + 0.5f, row + 0.5f);
  stone_[i] = point.stone;
  height_[i] = point.at.z();
  const bool sharp = point.stone >= 0 || !options_.loose;  // between loose stones is only shadow
  color_[i] = colors_.at(bed_.in_packing(point), point.stone < 0 ? -1 : bed_.particle(point.stone), sharp);
  return point;
}

void Painter::light_pixel(int x, int row) {
  const std::size_t i = at(x, row);
  const BedPoint point = color_pixel(x, row);
  Random random(options_.seed, kSkyStream, first_ + i);
  sky_[i] = shader_.sky(point, random.bits());
  sun_[i] = shader_.sun(point, random.bits());
}

// Few rays leave noise, which neighbors on the same stone average out.
std::vector<float> Painter::smooth(const std::vector<float>& values, const Work& work) const {
  std::vector<float> out(values.size());
  each_row(work, [&](int row) {
    for (int x = 0; x < options_.pixels_x; ++x) out[at(x, row)] = mean_near(values, x, row);
  });
  return out;
}

float Painter::mean_near(const std::vector<float>& values, int x, int row) const {
  const int last_x = std::min(options_.pixels_x - 1, x + kSmooth);
  const int last_row = std::min(options_.pixels_y - 1, row + kSmooth);
  const std::int32_t stone = stone_[at(x, row)];
  float sum = 0;
  int count = 0;
  for (int v = std::max(0, row - kSmooth); v <= last_row; ++v)
    for (int u = std::max(0, x - kSmooth); u <= last_x; ++u) {
      if (stone_[at(u, v)] != stone) continue;
      sum += values[at(u, v)];
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
