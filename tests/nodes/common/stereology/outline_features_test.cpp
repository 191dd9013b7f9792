#include "nodes/common/stereology/outline_features.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "runtime/random.h"

namespace terrazzo {
namespace {

using std::numbers::pi;
using F = OutlineFeature;

Loop ellipse(double a, double b, int n) {
  Loop loop;
  for (int i = 0; i < n; ++i) loop.emplace_back(a * std::cos(2 * pi * i / n), b * std::sin(2 * pi * i / n));
  return loop;
}

Loop star(std::uint64_t seed, double amplitude) {
  Random r(seed, 77);
  double c[6], s[6];
  for (int k = 2; k < 6; ++k) {
    c[k] = amplitude * r.normal() / k;
    s[k] = amplitude * r.normal() / k;
  }
  Loop loop;
  for (int i = 0; i < 300; ++i) {
    const double t = 2 * pi * i / 300;
    double f = 0;
    for (int k = 2; k < 6; ++k) f += c[k] * std::cos(k * t) + s[k] * std::sin(k * t);
    loop.push_back(std::exp(f) * Vec2(std::cos(t), std::sin(t)));
  }
  return loop;
}

TEST(OutlineFeatures, OfACircle) {
  const auto f = outline_features(ellipse(3, 3, 720));
  EXPECT_NEAR(f[F::Circularity], 1 / (4 * pi), 5e-5);
  EXPECT_NEAR(f[F::TotalCurvature], 2 * pi, 1e-9);
  EXPECT_NEAR(f[F::Aspect], 1, 1e-4);
  EXPECT_NEAR(f[F::Convexity], 1, 1e-12);
  EXPECT_NEAR(f[F::Corner], 15, 0.6);
  EXPECT_EQ(f[F::Corners], 0);
  EXPECT_NEAR(f[F::Symmetry], 1, 1e-3);
  EXPECT_NEAR(f[F::Anisotropy], 0, 1e-3);
  for (const F k : {F::CurvatureLow, F::CurvatureMedian, F::CurvatureHigh}) EXPECT_NEAR(f[k], 1, 0.05);
}

TEST(OutlineFeatures, OfASquareAndAnEllipse) {
  const auto f = outline_features({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  EXPECT_NEAR(f[F::Circularity], 1.0 / 16, 1e-9);
  EXPECT_NEAR(f[F::TotalCurvature], 2 * pi, 1e-9);
  EXPECT_NEAR(f[F::Corner], 90, 7);  // arcs are whole steps
  EXPECT_EQ(f[F::Corners], 4);
  EXPECT_NEAR(f[F::Symmetry], 1, 1e-6);
  EXPECT_NEAR(f[F::Anisotropy], 0, 1e-9);
  EXPECT_NEAR(f[F::CurvatureMedian], 0, 1e-9);
  const auto e = outline_features(ellipse(2, 1, 500));
  EXPECT_NEAR(e[F::Aspect], 0.5, 1e-3);
  EXPECT_GT(e[F::Symmetry], 0.995);
  EXPECT_GT(e[F::Anisotropy], 0.2);
}

TEST(OutlineFeatures, ReentrantOutlinesTurnFurther) {
  // A plus sign has eight convex and four concave right angles.
  const Loop plus{{1, 0}, {2, 0}, {2, 1}, {3, 1}, {3, 2}, {2, 2},
                  {2, 3}, {1, 3}, {1, 2}, {0, 2}, {0, 1}, {1, 1}};
  const auto f = outline_features(plus, {.points = 120});
  EXPECT_NEAR(f[F::TotalCurvature], 6 * pi, 1e-6);
  EXPECT_NEAR(f[F::Convexity], 5.0 / 7, 1e-9);
  EXPECT_EQ(f[F::Corners], 12);
  EXPECT_LT(f[F::CurvatureLow], 0);
}

TEST(OutlineFeatures, NeitherPlaceSizeNorTessellationCount) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    const Loop loop = star(seed, 0.5);
    const auto f = outline_features(loop);
    Random r(seed, 3);
    // The same curve with more points, some nearly coincident; translated, rotated and scaled.
    Loop other;
    const Eigen::Rotation2Dd turn(r.uniform(0, 6));
    const double scale = std::exp(r.uniform(-5, 5));
    const Vec2 move(r.uniform(-9, 9), r.uniform(-9, 9));
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec2 a = loop[i], b = loop[(i + 1) % loop.size()];
      for (const double t : {0.0, 1e-9, 0.3, 0.3, 0.7})
        other.push_back(scale * (turn * Vec2(a + t * (b - a))) + scale * move);
    }
    const auto g = outline_features(other);
    for (std::size_t k = 0; k < kOutlineFeatures; ++k)
      EXPECT_NEAR(g.values[k], f.values[k], 1e-4 * std::max(1.0, std::abs(f.values[k])))
          << outline_feature_names()[k];
  }
}

TEST(OutlineFeatures, TheAsymmetricIsToldFromTheSymmetric) {
  const auto f = outline_features({{0, 0}, {4, 0}, {1, 1}, {0.5, 3}});
  EXPECT_LT(f[F::Symmetry], 0.95);
  EXPECT_EQ(outline_features({}).values, OutlineFeatures{}.values);
  EXPECT_EQ(outline_features({{0, 0}, {1, 1}, {2, 2}}).values, OutlineFeatures{}.values);
}

}  // namespace
}  // namespace terrazzo
