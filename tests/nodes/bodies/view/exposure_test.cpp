// How bright lit stones are.
#include "nodes/bodies/view/exposure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/data/indices.h"

namespace terrazzo {
namespace {
using namespace view;

// Balls in rows under a sun from the right, as gray as given; between them, places in the shadow or soil.
struct Balls {
  static constexpr int kAcross = 5, kCell = 40, kRadius = 18, kWidth = kAcross * kCell;
  std::vector<std::int32_t> stone;
  std::vector<float> height, sun, sky;
  std::vector<Vec3f> color;

  explicit Balls(bool loose) {
    for (int row = 0; row < kWidth; ++row)
      for (int x = 0; x < kWidth; ++x) add(x, row, loose);
  }

  void add(int x, int row, bool loose) {
    const Vec3f light = Vec3f(1, 0, 1).normalized();
    const float u = (x % kCell + 0.5F - kCell / 2.0F) / kRadius;
    const float v = (row % kCell + 0.5F - kCell / 2.0F) / kRadius;
    const int ball = row / kCell * kAcross + x / kCell;
    const float z2 = 1 - u * u - v * v;
    const bool on = z2 > 0;
    const float z = on ? std::sqrt(z2) : -1;
    stone.push_back(on ? ball : loose ? 99 : -1);
    height.push_back(z);
    sun.push_back(on ? std::max(0.0F, Vec3f(u, -v, z).dot(light)) / light.z() : 0.2F);
    sky.push_back(on ? (1 + z) / 2 : 0.3F);
    color.push_back(Vec3f::Constant(on ? 0.2F + 0.02F * ball : 0.3F));
  }

  UnlitPixels pixels() const { return {stone, height, color, sun, sky, -0.5F, kWidth, 0.2F}; }
};

// The median slope of ln light across balls, per radius, to the right.
double slope_of(const Balls& b, const std::vector<float>& light) {
  double sum = 0;
  for (int ball = 0; ball < Balls::kAcross * Balls::kAcross; ++ball) {
    double xx = 0, xv = 0, x1 = 0, v1 = 0, n = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      if (b.stone[i] != ball) continue;
      const double x = double(i % Balls::kWidth) / Balls::kRadius, v = std::log(light[i]);
      xx += x * x;
      xv += x * v;
      x1 += x;
      v1 += v;
      ++n;
    }
    sum += (xv - x1 * v1 / n) / (xx - x1 * x1 / n);
  }
  return sum / (Balls::kAcross * Balls::kAcross);
}

TEST(Exposure, SlopesOfStonesAreThePhotographs) {
  const Balls balls(false);
  for (const double wanted : {0.2, 0.35, 0.5}) {
    SurfaceOptions options;
    options.slope = Vec2(wanted, 0);
    const auto light = exposure(balls.pixels(), options, {});
    EXPECT_NEAR(slope_of(balls, light), wanted, 0.02);
  }
}

// Of a photograph whose darkest pixels are by this logarithm darker than the middle.
std::vector<float> tones_of(float contrast) {
  std::vector<float> tones(100, 0.2F);
  std::fill_n(tones.begin(), 20, 0.2F * std::exp(-contrast));
  return tones;
}

// The same of a picture.
double contrast_of(const Balls& b, const std::vector<float>& light) {
  std::vector<float> tones;
  for (std::size_t i = 0; i < light.size(); ++i) tones.push_back(light[i] * b.color[i].x());
  std::sort(tones.begin(), tones.end());
  return std::log(tones[tones.size() / 2] / tones[tones.size() / 20]);
}

TEST(Exposure, SlopesAndShadowsAgree) {
  const Balls balls(true);
  SurfaceOptions options;
  options.slope = Vec2(0.3, 0);
  options.loose = true;
  options.tones = tones_of(1);
  const auto light = exposure(balls.pixels(), options, {});
  EXPECT_NEAR(slope_of(balls, light), 0.3, 0.05);
  EXPECT_NEAR(contrast_of(balls, light), 1, 0.1);
}

// Without a photograph's tones, nothing tells how dark shadows are.
TEST(Exposure, LeavesLightAsItIsWithoutTones) {
  const Balls balls(true);
  SurfaceOptions options, loose;
  loose.loose = true;
  EXPECT_EQ(exposure(balls.pixels(), options, {}), exposure(balls.pixels(), loose, {}));
}

TEST(Exposure, StonesAreAsBrightAsInThePhotograph) {
  const Balls balls(false);
  SurfaceOptions options;
  options.brightness = 0.4F;
  const auto light = exposure(balls.pixels(), options, {});
  double sum = 0;
  for (int ball = 0; ball < 25; ++ball) {
    std::vector<float> own;
    for (std::size_t i = 0; i < light.size(); ++i)
      if (balls.stone[i] == ball) own.push_back(light[i] * balls.color[i].x());
    std::nth_element(own.begin(), own.begin() + own.size() / 2, own.end());
    sum += own[own.size() / 2];
  }
  EXPECT_NEAR(sum / 25, 0.4, 0.004);
  double soil = 0, pixels = 0;  // keeps the color that was measured
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (balls.stone[i] >= 0) continue;
    soil += light[i];
    ++pixels;
  }
  EXPECT_NEAR(soil / pixels, 1, 1e-3);
}

// Mean logarithms of the balls' brightness: how much they differ.
double difference_of(const Balls& b, const std::vector<float>& light) {
  std::vector<double> sum(25), n(25);
  for (std::size_t i = 0; i < b.stone.size(); ++i) {
    if (b.stone[i] < 0) continue;
    sum[b.stone[i]] += std::log(light[i] * b.color[i].x());
    ++n[b.stone[i]];
  }
  double first = 0, second = 0;
  for (int k = 0; k < 25; ++k) {
    first += sum[k] / n[k] / 25;
    second += sum[k] / n[k] * sum[k] / n[k] / 25;
  }
  return std::sqrt(second - first * first);
}

TEST(Exposure, StonesDifferAsInThePhotographWhoseColorsHoldItsLight) {
  Balls balls(false);
  const double photographed = difference_of(balls, std::vector<float>(balls.stone.size(), 1));
  for (std::size_t i = 0; i < balls.stone.size(); ++i)  // some lie deep
    if (balls.stone[i] >= 0) {
      const float open = 1 - 0.15F * static_cast<float>(balls.stone[i] % 5);
      balls.sky[i] *= open;
      balls.sun[i] *= open;
    }
  SurfaceOptions options;
  const double twice = difference_of(balls, exposure(balls.pixels(), options, {}));
  options.brightness = 0.4F;
  const double once = difference_of(balls, exposure(balls.pixels(), options, {}));
  EXPECT_GT(twice, 1.15 * photographed);
  EXPECT_NEAR(once, photographed, 0.08 * photographed);
}

// Darker and lighter shadows than the light alone makes.
TEST(Exposure, ShadowsOfLooseStonesAreAsDarkAsInThePhotograph) {
  const Balls balls(true);
  for (const float wanted : {0.6F, 1.0F, 1.6F}) {
    SurfaceOptions options;
    options.loose = true;
    options.brightness = 0.4F;
    options.tones = tones_of(wanted);
    EXPECT_NEAR(contrast_of(balls, exposure(balls.pixels(), options, {})), wanted, 0.1) << wanted;
  }
}

}  // namespace
}  // namespace terrazzo
