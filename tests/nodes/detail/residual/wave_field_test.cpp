#include "nodes/detail/residual/wave_field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "nodes/data/detail.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using residual::WaveField;

const Vec3 kBox(60, 45, 50);

Vec3f somewhere(Random& r) {
  const auto x = static_cast<float>(r.uniform(0, kBox.x())), y = static_cast<float>(r.uniform(0, kBox.y()));
  return {x, y, static_cast<float>(r.uniform(0, kBox.z()))};
}

TEST(WaveField, HasTheBoxsPeriod) {
  const WaveField field(std::array{1.0f, 4.0f}, std::array{0.3f, 0.7f}, kBox);
  Random random(3);
  for (int n = 0; n < 100; ++n) {
    const Vec3f at = somewhere(random);
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR(field.at(at), field.at(at + Vec3f::Unit(a) * static_cast<float>(kBox[a])), 2e-3);
  }
}

// Variance 1 and the covariance Σ v · exp(−r² / 4σ²), which the rounding of waves to the box hardly changes.
TEST(WaveField, HasItsCovariance) {
  const std::array sigma{1.0f, 4.0f}, variance{0.3f, 0.7f};
  const WaveField field(sigma, variance, kBox);
  constexpr int kPoints = 60000;
  for (const double r : {0.0, 1.0, 3.0, 6.0, 12.0}) {
    double sum = 0, expected = 0;
    Random random(4);
    for (int n = 0; n < kPoints; ++n) {
      const Vec3f at = somewhere(random);
      const Vec3 direction = Vec3(random.normal(), random.normal(), random.normal()).normalized();
      sum += static_cast<double>(field.at(at)) *
             static_cast<double>(field.at(at + (r * direction).cast<float>()));
    }
    for (int k = 0; k < 2; ++k)
      expected += static_cast<double>(variance[k]) * std::exp(-r * r / (4.0 * sigma[k] * sigma[k]));
    EXPECT_NEAR(sum / kPoints, expected, 0.06) << r;
  }
}

// The binder is dark with the probability of the level, by distance, and has the offsets of its zones.
TEST(WaveField, ZonesHaveTheirShares) {
  Detail d;
  d.pixel_size = 1;
  d.size = 8;
  d.softness = 0.1;
  Detail::Phase flat;
  flat.tile.assign(512, Vec3f::Zero());
  d.phases.assign(2, flat);
  d.zones.sigma = {2.0f};
  d.zones.variance = {1.0f};
  d.zones.level = {-0.6745f, -0.6745f, 0.6745f};
  d.zones.mean_level = -0.2533f;
  d.zones.dark.setConstant(-0.3f);
  d.zones.light.setConstant(0.2f);
  Particles p;
  p.box = kBox;
  const residual::ResidualField field(d, p, 0.01);
  for (const auto& [depth, share] : {std::pair{0.5f, 0.25}, {50.0f, 0.75}}) {
    double dark = 0, between = 0;
    Random random(5);
    constexpr int kPoints = 40000;
    for (int n = 0; n < kPoints; ++n) {
      const float v = field.at(somewhere(random), -1, depth).x();
      dark += v < -0.05f;
      between += v > -0.29f && v < 0.19f;
      ASSERT_TRUE(v >= -0.301f && v <= 0.201f);
    }
    EXPECT_NEAR(dark / kPoints, share, 0.03);
    EXPECT_LT(between / kPoints, 0.25);
  }
  // Where no distance is known, the binder has its mean share.
  double dark = 0;
  Random random(6);
  for (int n = 0; n < 40000; ++n) dark += field.at(somewhere(random), -1).x() < -0.05f;
  EXPECT_NEAR(dark / 40000, 0.4, 0.03);
}

}  // namespace
}  // namespace terrazzo
