#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "nodes/shapes/shape_estimate/outline.h"
#include "tests/nodes/shapes/shape_estimate/synthetic_profiles.h"

namespace terrazzo {
namespace {

using namespace shape_estimate;
namespace made = shape_estimate::test;

using std::numbers::pi;

TEST(ShapeEstimateOutline, AlignsTheLongAxisWithX) {
  for (const double turn : {0.0, 0.4, 1.3, 2.9}) {
    const auto o = make_outline(1, made::ellipse(3, 1, 300, {40, -7}, turn), 40);
    EXPECT_NEAR(o.width, 6, 0.01);
    EXPECT_NEAR(o.height, 2, 0.01);
    EXPECT_NEAR(o.aspect, 1.0 / 3, 0.003);
    EXPECT_NEAR(o.area, 3 * pi, 0.01);
    EXPECT_NEAR(o.convexity, 1, 1e-9);
    EXPECT_EQ(o.corners, 0);
    Vec2 sum = Vec2::Zero();
    for (const auto& p : o.points) sum += p / static_cast<double>(o.points.size());
    EXPECT_LT(sum.norm(), 0.05);
  }
}

TEST(ShapeEstimateOutline, ClockwiseAndRepeatedPointsAreTaken) {
  auto c = made::rectangle(3, 2);
  std::reverse(c.begin(), c.end());
  c.push_back(c.back());
  c.push_back(c.front());
  const auto o = make_outline(1, c, 40);
  EXPECT_NEAR(o.area, 6, 1e-12);
  EXPECT_NEAR(o.width, 3, 1e-12);
}

TEST(ShapeEstimateOutline, PolygonsKeepTheirCorners) {
  for (const int n : {3, 4, 5, 6, 8}) {
    made::Contour c;
    for (int i = 0; i < n; ++i) c.push_back(made::ellipse(1, 1, n)[i]);
    const auto o = make_outline(1, c, 40);
    EXPECT_EQ(o.corners, n);
    for (const double c : o.corner) EXPECT_TRUE(c == 0 || std::abs(c - 360.0 / n) < 1e-6);
  }
  EXPECT_EQ(make_outline(1, made::rectangle(1, 1), 91).corners, 0);
}

TEST(ShapeEstimateOutline, ReentrantCornersAreNegative) {
  const auto o = make_outline(1, {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 40);
  int inward = 0;
  for (const double c : o.corner) inward += c < 0;
  EXPECT_EQ(o.corners, 6);
  EXPECT_EQ(inward, 1);
}

TEST(ShapeEstimateOutline, PixelStepsAreSmoothedAway) {
  for (const double radius : {5.0, 12.0, 40.0}) {
    SCOPED_TRACE(radius);
    const auto steps = made::pixelated(made::ellipse(radius, radius), 1);
    ASSERT_GT(steps.size(), 20u);
    const auto o = make_outline(1, steps, 30);
    EXPECT_EQ(o.corners, 0);
    EXPECT_NEAR(o.area / (pi * radius * radius), 1, 0.06);
    EXPECT_GT(o.circularity, 0.97);
  }
  // Corners of a stepped square are not steps. It is rotated, so that its sides have steps too.
  const auto square = make_outline(1, made::pixelated(made::ellipse(40, 40, 4, {0, 0}, 0.3), 1), 30);
  EXPECT_EQ(square.corners, 4);
  const auto pentagon = make_outline(1, made::pixelated(made::ellipse(20, 20, 5, {0, 0}, 0.3), 1), 30);
  EXPECT_EQ(pentagon.corners, 5);
}

TEST(ShapeEstimateOutline, SteppedPolygonsKeepTheirCorners) {
  // A radius of fourteen pixels, with pixel steps: smoothing must neither remove nor blunt the corners.
  for (const int n : {3, 4, 5, 6})
    for (const double turn : {0.1, 0.35}) {
      const auto polygon = made::ellipse(14, 14, n, {0, 0}, turn);
      made::Contour stepped;
      for (int i = 0; i < n; ++i) {
        const Vec2 a = polygon[i], b = polygon[(i + 1) % n];
        const int steps = static_cast<int>((b - a).norm() / 0.8);
        for (int k = 0; k < steps; ++k) {
          const Vec2 across = Vec2(a.y() - b.y(), b.x() - a.x()).normalized();
          stepped.push_back(a + (b - a) * (static_cast<double>(k) / steps) +
                            (k == 0  ? 0
                             : k % 2 ? 0.2
                                     : -0.2) *
                                across);
        }
      }
      const auto o = make_outline(1, stepped, 30);
      EXPECT_EQ(o.corners, n);
      double turns = 0;
      for (const double c : o.corner) turns += c;
      EXPECT_NEAR(turns, 360, 60);
      const double circularity = pi / n / std::tan(pi / n);
      EXPECT_NEAR(o.circularity, circularity, 0.025);
      EXPECT_NEAR(o.area, n * 14 * 14 * std::sin(2 * pi / n) / 2, 0.02 * o.area);
    }
}

TEST(ShapeEstimateOutline, SampledCurvesAreNotSmoothed) {
  // Thirty points of an ellipse: smoothing over their distance would visibly round it.
  const auto o = make_outline(1, made::ellipse(2, 1, 30), 40);
  EXPECT_NEAR(o.width, 4, 0.03);
  EXPECT_NEAR(o.height, 2, 0.03);
}

TEST(ShapeEstimateOutline, MirrorsAndTurnsKeepTheCurve) {
  Random r(3);
  const auto o = make_outline(1, made::random_star(r, 0.3), 40);
  for (const auto& m : {o.mirrored_x(), o.mirrored_y(), o.turned()}) {
    double area = 0;
    for (std::size_t i = 0; i < m.points.size(); ++i) {
      const Vec2 &a = m.points[i], &b = m.points[(i + 1) % m.points.size()];
      area += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
    EXPECT_NEAR(area, o.area, 1e-9);
  }
  EXPECT_EQ(o.turned().width, o.height);
  EXPECT_EQ(o.turned().aspect, 1 / o.aspect);
}

TEST(ShapeEstimateOutline, FaultsAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(outline_fault(made::rectangle(1, 1)), "");
  EXPECT_NE(outline_fault({}), "");
  EXPECT_NE(outline_fault({{0, 0}, {1, 0}}), "");
  EXPECT_NE(outline_fault({{0, 0}, {1, 0}, {1, 0}, {0, 0}}), "");
  EXPECT_NE(outline_fault({{0, 0}, {1, 0}, {nan, 1}}), "");
  EXPECT_NE(outline_fault({{0, 0}, {1, 0}, {2, 0}}), "");
  EXPECT_NE(outline_fault({{0, 0}, {1, 1}, {1, 0}, {0, 1.2}}).find("crosses itself"), std::string::npos);
}

}  // namespace
}  // namespace terrazzo
