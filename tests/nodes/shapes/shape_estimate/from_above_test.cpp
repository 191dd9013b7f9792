// Stones of a surface: silhouettes and the axis that nobody sees.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/shortest_axis.h"
#include "nodes/packing/rigid/lying.h"
#include "nodes/shapes/shape_estimate/from_above.h"
#include "nodes/shapes/shape_estimate/outline.h"
#include "tests/nodes/shapes/shape_estimate/synthetic_profiles.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape_estimate;
using std::numbers::pi;

Shapes ellipsoid(double a, double b, double c) {
  Shapes s =
      terrazzo::test::run_node("Shape", {}, {{"kind", "sphere"}, {"size", "2"}}).output<Shapes>("shapes");
  for (Vec3& v : s.shapes[0].mesh.vertices) v = v.cwiseProduct(Vec3(a, b, c));
  return s;
}

TEST(FromAbove, SilhouettesOfAnEllipsoid) {
  const Mesh mesh = ellipsoid(2, 1.5, 1).shapes[0].mesh;
  const auto views = seen_from_above(mesh, 200);
  ASSERT_EQ(views.size(), 200u);
  double mean = 0, least = 1e300;
  for (const CutProfile& s : views) {
    mean += s.root_area * s.root_area / 200;
    least = std::min(least, s.root_area * s.root_area);
    EXPECT_LE(s.root_area * s.root_area, 3 * pi * 1.001);
    EXPECT_NEAR(s.root_area * s.root_area, loop_area(s.loop), 1e-9);
  }
  // The shadow along n has the area π·√(b²c²n_x² + a²c²n_y² + a²b²n_z²); tilts of 0.3 take a few percent.
  EXPECT_GT(mean, 0.93 * 3 * pi);
  EXPECT_LT(mean, 0.99 * 3 * pi);
  EXPECT_LT(least, 0.9 * 3 * pi);
}

TEST(FromAbove, ThicknessIsRelativeToTheShorterAxis) {
  Mesh mesh = ellipsoid(2, 1.5, 1.2).shapes[0].mesh;
  const double before = mesh_volume(mesh);
  give_thickness(mesh, 0.6);
  double high = 0;
  for (const Vec3& v : mesh.vertices) high = std::max(high, v.z());
  EXPECT_NEAR(high, 0.6 * 1.5, 0.01);
  EXPECT_NEAR(mesh_volume(mesh) / before, 0.6 * 1.5 / 1.2, 0.01);
}

TEST(FromAbove, AssumesTheRatioThatItSees) {
  namespace made = shape_estimate::test;
  const auto outlines =
      made::outlines_of({made::ellipse(1, 0.7), made::ellipse(2, 1.4), made::ellipse(1, 0.5)}, 40);
  EXPECT_NEAR(assumed_thickness(outlines), 0.7, 0.01);
  EXPECT_EQ(assumed_thickness({}), 1);
}

TEST(FromAbove, TheShortestAxisTurnsUp) {
  Mesh mesh = ellipsoid(1, 2, 3).shapes[0].mesh;
  const auto up = shortest_axis_up(mesh);
  ASSERT_TRUE(up);
  EXPECT_NEAR(std::abs((*up * Vec3::UnitX()).z()), 1, 1e-3);
  EXPECT_FALSE(shortest_axis_up(ellipsoid(1, 1, 1).shapes[0].mesh));
  lie_down(mesh);
  double high = 0;
  for (const Vec3& v : mesh.vertices) high = std::max(high, v.z());
  EXPECT_NEAR(high, 1, 0.01);
}

TEST(LayFlat, ShortAxesPointUpWithATilt) {
  const Shapes shapes = ellipsoid(0.5, 1, 1.2);
  packing::Packing p;
  constexpr int kCount = 2000;
  p.shape.assign(kCount, 0);
  p.position.assign(kCount, Vec3::Zero());
  p.orientation.assign(kCount, Quat::Identity());
  packing::lay_flat(p, shapes, 500, {}, 3);
  for (int i = 0; i < 500; ++i) EXPECT_EQ(p.orientation[i].coeffs(), Quat::Identity().coeffs());
  double square = 0, up = 0;
  Vec2 azimuth = Vec2::Zero();
  for (int i = 500; i < kCount; ++i) {
    const Vec3 axis = p.orientation[i] * Vec3::UnitX(), longest = p.orientation[i] * Vec3::UnitZ();
    square += std::pow(std::acos(std::min(1.0, std::abs(axis.z()))), 2) / (kCount - 500);
    up += axis.z() > 0;
    azimuth += longest.head<2>().normalized() / (kCount - 500);
  }
  EXPECT_NEAR(square, 2 * kTilt * kTilt, 0.1 * 2 * kTilt * kTilt);  // two independent tilts
  EXPECT_NEAR(up / (kCount - 500), 0.5, 0.05);
  EXPECT_LT(azimuth.norm(), 0.07);
}

TEST(LayFlat, TracedStonesLieAsInThePhotograph) {
  Shapes shapes = ellipsoid(1.2, 1, 0.5);
  shapes.shapes[0].traced = {3, Vec2(1, 2), 0.8};
  packing::Packing p;
  constexpr int kCount = 2000;
  p.shape.assign(kCount, 0);
  p.position.assign(kCount, Vec3::Zero());
  p.orientation.assign(kCount, Quat::Identity());
  packing::lay_flat(p, shapes, 0, {2.5}, 3);
  double sum = 0, square = 0;
  for (const Quat& q : p.orientation) {
    EXPECT_GT((q * Vec3::UnitZ()).z(), -0.2);  // the same side is up
    const Vec3 axis = q * Vec3::UnitX();
    const double off = std::remainder(std::atan2(axis.y(), axis.x()) - 0.8, 2 * pi);
    sum += off / kCount;
    square += off * off / kCount;
  }
  EXPECT_NEAR(sum, 0, 0.04);
  EXPECT_NEAR(std::sqrt(square), 0.15, 0.03);
}

// Where the photograph shows a mesh's silhouette, there the stone's outline is.
TEST(FromAbove, TracedShapesKnowTheirPlaceInThePhotograph) {
  Profiles p;
  p.view = View::Surface;
  for (int k = 0; k < 30; ++k) {
    Profile q;
    const Eigen::Rotation2Dd turn(0.3 * k);
    for (int i = 0; i < 90; ++i) {
      const double t = 2 * pi * i / 90;
      const double r = 1 + 0.15 * std::cos(3 * t + k) + 0.05 * std::cos(5 * t);
      q.contour.push_back(Vec2(10 * k, 5) + turn * Vec2(2 * r * std::cos(t), 1.3 * r * std::sin(t)));
    }
    q.area = q.whole = loop_area(q.contour);
    p.profiles.push_back(q);
  }
  const auto run =
      terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of<Profiles>(p)}}, {{"method", "auto"}});
  for (const Shape& s : run.output<Shapes>("shapes").shapes) {
    ASSERT_GE(s.traced.profile, 1) << s.name;
    const Loop& contour = p.profiles[s.traced.profile - 1].contour;
    double farthest = 0;
    for (const Vec2& c : contour) {
      double nearest = 1e9;
      for (const Vec3& v : s.mesh.vertices)
        nearest = std::min(
            nearest, (s.traced.origin + Eigen::Rotation2Dd(s.traced.turn) * Vec2(v.head<2>()) - c).norm());
      farthest = std::max(farthest, nearest);
    }
    EXPECT_LT(farthest, 0.25) << s.name;  // the mesh has a vertex at least every 0.2 mm
  }
}

// Outlines that follow pixels are smoothed, which must not move them.
TEST(FromAbove, SmoothedOutlinesStayInTheirPlace) {
  const Vec2 center(2000, 1500);
  constexpr int kRadius = 12;
  std::vector<Vec2> steps;  // around the disc, one for each pixel of its border
  for (int k = 0; k < 72; ++k) {
    const double t = 2 * pi * k / 72;
    steps.push_back(center + Vec2(std::round(kRadius * std::cos(t)), std::round(kRadius * std::sin(t))));
  }
  const Outline o = make_outline(1, steps, 25);
  EXPECT_GT(o.blur, 0);
  EXPECT_NEAR((o.center - center).norm(), 0, 0.1);
}

// Balls in the light, and parts of balls in the shadow: all shapes are balls.
TEST(FromAbove, PartsOfBallsAreNoShapes) {
  Profiles p;
  p.view = View::Surface;
  p.classes = 2;
  for (int k = 0; k < 80; ++k) {
    Profile q;
    q.cls = k >= 50;
    const double radius = q.cls ? 0.7 : 1 + 0.01 * k;
    for (int i = 0; i < 60; ++i) {
      const double t = 2 * pi * i / 60;
      const double r = q.cls ? radius * (1 + 0.2 * std::cos(2 * t) + 0.15 * std::cos(3 * t + k)) : radius;
      q.contour.emplace_back(3 + r * std::cos(t), 3 + r * std::sin(t));
    }
    q.area = q.whole = loop_area(q.contour);
    p.profiles.push_back(q);
  }
  const auto run = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of<Profiles>(p)}},
                                            {{"method", "auto"}, {"class", "each"}});
  EXPECT_EQ(run.metrics.at("classes_with_shapes_of_all"), 1);
  for (const Shape& s : run.output<Shapes>("shapes").shapes) {
    EXPECT_GE(s.traced.profile, 1) << s.name;
    EXPECT_LE(s.traced.profile, 50) << s.name;
  }
}

// Stones of a surface: as many shapes as asked, lying, with the photograph's outlines from above.
TEST(FromAbove, ShapesOfASurfaceLieFlat) {
  namespace made = shape_estimate::test;
  Profiles p;
  p.view = View::Surface;
  for (int k = 0; k < 30; ++k) {
    Profile q;
    for (int i = 0; i < 60; ++i) {
      const double t = 2 * pi * i / 60;
      q.contour.emplace_back(3 + 2 * std::cos(t), 3 + (1 + 0.02 * k) * std::sin(t));
    }
    q.area = q.whole = pi * 2 * (1 + 0.02 * k);
    p.profiles.push_back(q);
  }
  for (int k = 0; k < 5; ++k) p.profiles[k].whole *= 1.5;  // hidden by others
  const auto run =
      terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of<Profiles>(p)}}, {{"method", "auto"}});
  EXPECT_EQ(run.metrics.at("usable_profiles"), 25);
  EXPECT_EQ(run.metrics.at("shapes"), 25);
  EXPECT_NEAR(run.metrics.at("thickness"), 0.67, 0.05);
  for (const Shape& s : run.output<Shapes>("shapes").shapes) {
    Vec3 high = Vec3::Constant(-1e300), low = -high;
    for (const Vec3& v : s.mesh.vertices) {
      high = high.cwiseMax(v);
      low = low.cwiseMin(v);
    }
    const Vec3 extent = high - low;
    EXPECT_NEAR(extent.z() / extent.head<2>().minCoeff(), run.metrics.at("thickness"), 0.08) << s.name;
  }
  const auto thin = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of<Profiles>(p)}},
                                             {{"method", "auto"}, {"thickness", "0.3"}, {"count", "2"}});
  EXPECT_EQ(thin.metrics.at("shapes"), 2);
  EXPECT_EQ(thin.metrics.at("thickness"), 0.3);
}

}  // namespace
}  // namespace terrazzo
