// Correction by sections, and the binder between neighbors.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/packing/cells/corner_roundness.h"
#include "nodes/packing/cells/joints.h"
#include "nodes/packing/cells/section_fit.h"
#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {
using namespace tessellation;

// N_A = Σ N_V·H̄: all profiles of convex particles, whatever their classes.
TEST(SectionFit, CountsAllProfiles) {
  const Shapes shapes = test::shapes_of({test::ellipsoid(2)});
  Particles p;
  p.box = Vec3(10, 10, 10);
  p.resize(3);
  p.shape = {0, 0, 0};
  p.scale = {1, 2, 0.5};
  const Eigen::MatrixXd n = profile_densities(shapes, p, {0, 1, 0}, {0, 1, 10}, 2000, 1);
  EXPECT_NEAR(n.sum(), shapes.shapes[0].mean_caliper * 3.5 / 1000, 1e-9);
  EXPECT_NEAR(n.row(1).sum(), shapes.shapes[0].mean_caliper * 2 / 1000, 1e-9);
}

TEST(SectionFit, NothingToCorrect) {
  SizeDistribution d;
  d.class_edges = {0, 1, 2};
  d.shapes.push_back({0, 0, {3, 5}, {}, {}});
  Eigen::MatrixXd shown(2, 2);
  shown << 2, 0, 1, 4;
  correct(d, shown.colwise().sum(), shown);
  EXPECT_NEAR(d.shapes[0].N_V[0], 3, 1e-12);
  EXPECT_NEAR(d.shapes[0].N_V[1], 5, 1e-12);
  // Twice as many large profiles: only particles of the second class show them.
  correct(d, Eigen::Vector2d(3, 8), shown);
  EXPECT_NEAR(d.shapes[0].N_V[0], 3, 1e-12);
  EXPECT_NEAR(d.shapes[0].N_V[1], 5 * (1 + 2 * 4) / 5.0, 1e-12);
}

TEST(SectionFit, MisfitOfEqualAndDisjoint) {
  EXPECT_NEAR(misfit(Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(2, 4, 6)), 0, 1e-15);
  EXPECT_NEAR(misfit(Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 3)), 1, 1e-15);
  // Two classes of equal probability: half of E|k/n − ½|·2, with E|k − n/2| = √(n / 2π)
  EXPECT_NEAR(sampling_misfit(Eigen::Vector2d(1, 1), 400), std::sqrt(400 / (2 * 3.14159265)) / 400, 1e-6);
}

// Cells of a Laguerre tessellation are not spheres, so their sections differ from those of the spheres whose
// volumes they have. Corrections bring them closer.
TEST(SectionFit, CorrectionsReduceTheMisfit) {
  const Shapes shapes = test::shapes_of({test::ellipsoid(2)});
  const SizeDistribution d = test::distribution(shapes, 1, 3, 0.9999999);
  const auto run = [&](const char* corrections) {
    return test::run_node(
        "Tessellate",
        {{"shapes", Value::of<Shapes>(shapes)}, {"distribution", Value::of<SizeDistribution>(d)}},
        {{"count", "600"}, {"corrections", corrections}, {"rounds", "2"}}, {}, 2);
  };
  const auto none = run("0"), some = run("4");
  EXPECT_EQ(none.metrics.at("section_misfit"), none.metrics.at("section_misfit_before"));
  EXPECT_LE(some.metrics.at("section_misfit"), some.metrics.at("section_misfit_before"));
  EXPECT_LT(some.metrics.at("section_misfit"), some.metrics.at("section_misfit_by_chance"));
}

Profile square(double x, double y, double edge, int section = 0) {
  Profile p;
  p.section = section;
  p.area = edge * edge;
  p.contour = {{x, y}, {x + edge, y}, {x + edge, y + edge}, {x, y + edge}};
  return p;
}

// Hexagons with the edges cut by arcs: a regular hexagon rounded by a circle of `radius` at each corner.
Profiles rounded_hexagons(double radius) {
  Profiles p;
  for (int n = 0; n < 5; ++n) {
    Profile q;
    const double inner = 1 - radius;  // the arcs' centers are the corners of a hexagon with this inner radius
    for (int k = 0; k < 6; ++k) {
      const double at = (k + 0.5) * std::numbers::pi / 3 + n;
      const Vec2 center = inner / std::cos(std::numbers::pi / 6) * Vec2(std::cos(at), std::sin(at));
      for (int i = 0; i <= 8; ++i) {
        const double t = at + (i / 8.0 - 0.5) * std::numbers::pi / 3;
        q.contour.push_back((3 + n) * (center + radius * Vec2(std::cos(t), std::sin(t))));
      }
    }
    p.profiles.push_back(q);
  }
  return p;
}

TEST(CornerRoundness, GrowsWithTheRadiusOfCorners) {
  double last = -1;
  for (const double radius : {0.02, 0.3, 0.6, 0.9}) {
    const double found = measure_roundness(rounded_hexagons(radius));
    EXPECT_GT(found, last) << radius;
    EXPECT_LE(found, 1);
    last = found;
  }
  EXPECT_LT(measure_roundness(rounded_hexagons(0.02)), 0.15);
  EXPECT_GT(last, 0.6);
}

TEST(CornerRoundness, TooFewProfilesAreSharp) {
  Profiles p = rounded_hexagons(0.9);
  p.profiles.resize(2);
  EXPECT_EQ(measure_roundness(p), 0);
  EXPECT_EQ(measure_roundness({}), 0);
}

TEST(Joints, DistanceBetweenSquares) {
  Profiles p;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) p.profiles.push_back(square(1.1 * i, 1.1 * j, 1));
  const Joints joints = measure_joints(p);
  EXPECT_NEAR(joints.thickness, 0.1 / 1.09, 0.004);
  EXPECT_LT(joints.variation, 0.1);
}

TEST(Joints, OtherSectionsDoNotCount) {
  Profiles p;
  p.profiles = {square(0, 0, 1), square(1.2, 0, 1, 1), square(1.05, 0, 1, 2)};
  EXPECT_EQ(measure_joints(p).thickness, 0);
  EXPECT_EQ(measure_joints(Profiles{}).thickness, 0);
}

}  // namespace
}  // namespace terrazzo
