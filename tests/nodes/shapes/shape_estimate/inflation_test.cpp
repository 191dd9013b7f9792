// Bodies of stones whose silhouette a photograph shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/shapes/shape_estimate/from_above.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/relief.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace shape_estimate;
using std::numbers::pi;

// An ellipse with the half axes a and b whose radii differ by up to `wave`.
Outline wavy(double a, double b, double wave, int waves = 5) {
  std::vector<Vec2> contour;
  for (int i = 0; i < 400; ++i) {
    const double t = 2 * pi * i / 400;
    contour.push_back((1 + wave * std::cos(waves * t)) * Vec2(a * std::cos(t), b * std::sin(t)));
  }
  return make_outline(1, contour, 180);
}

Mesh inflated(const Outline& outline, double relief, int index = 0) {
  EstimateRequest request;
  request.chosen = {outline};
  request.relief = relief;
  request.index = index;
  return inflation(request, {}).mesh;
}

TEST(Relief, IsThatOfTheRadii) {
  EXPECT_NEAR(relief_of(wavy(3, 2, 0)), 0, 1e-3);
  EXPECT_NEAR(relief_of(wavy(1, 1, 0.05)), 0.05 / std::numbers::sqrt2, 1e-3);
  EXPECT_NEAR(relief_of(wavy(3, 2, 0.1)), 0.1 / std::numbers::sqrt2, 5e-3);
}

// Hidden parts and errors make outlines rougher, so a quarter of good ones is enough.
TEST(Relief, OfAllIsThatOfTheSmoothest) {
  std::vector<Outline> outlines(30, wavy(1, 1, 0.01));
  for (int k = 0; k < 70; ++k) outlines.push_back(wavy(1, 1, 0.1 + 0.001 * k));
  EXPECT_NEAR(usual_relief(outlines), 0.01 / std::numbers::sqrt2, 1e-3);
  EXPECT_EQ(usual_relief({}), 0);
}

TEST(Inflation, AnEllipseBecomesAnEllipsoid) {
  const Mesh mesh = inflated(wavy(3, 2, 0), 0);
  for (const Vec3& v : mesh.vertices) EXPECT_NEAR(v.cwiseQuotient(Vec3(3, 2, 2)).norm(), 1, 0.02);
  EXPECT_NEAR(mesh_volume(mesh), 4 * pi / 3 * 3 * 2 * 2, 0.02 * 50);
}

// Balls have round outlines, and what pixels add to them is not their form.
TEST(Inflation, BallsAreRound) {
  const Mesh mesh = inflated(wavy(1, 1, 0.03), 0.021);
  for (const Vec3& v : mesh.vertices) EXPECT_NEAR(v.norm(), 1, 0.02);
}

// Whether no triangle is upright or overhangs: those above the plane face up and those below face down.
bool each_side_has_one_height(const Mesh& mesh) {
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double up = (b - a).cross(c - a).z();
    return up * (a.z() + b.z() + c.z()) > 0;
  });
}

TEST(Inflation, TheSilhouetteIsTheOutline) {
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    const Outline outline = wavy(1 + random.uniform(), 1, 0.1 * random.uniform(), 2 + random.below(5));
    const Mesh mesh = inflated(outline, 0.03 + 0.05 * random.uniform(), k);
    std::vector<Vec2> rim;
    double high = 0, low = 0;
    for (const Vec3& v : mesh.vertices) {
      if (v.z() == 0) rim.push_back(v.head<2>());
      high = std::max(high, v.z());
      low = std::min(low, v.z());
    }
    EXPECT_NEAR(loop_area(rim), outline.area, 0.01 * outline.area) << k;
    EXPECT_TRUE(each_side_has_one_height(mesh)) << k;
    EXPECT_GT(mesh_volume(mesh), 0) << k;
    EXPECT_GT(high, 0.5) << k;
    EXPECT_LT(low, -0.5) << k;
  }
}

// Worn faces lower a ball's radii as unevenly as the outlines, and not everywhere.
TEST(Inflation, FacesHaveTheReliefOfOutlines) {
  constexpr double kRelief = 0.06;
  double sum = 0, squares = 0, n = 0;
  for (int k = 0; k < 40; ++k)
    for (const Vec3& v : inflated(wavy(1, 1, 0), kRelief, k).vertices) {
      if (std::abs(v.z()) < 0.3) continue;
      sum += v.norm();
      squares += v.squaredNorm();
      ++n;
    }
  const double deviation = std::sqrt(squares / n - sum / n * (sum / n));
  EXPECT_GT(deviation, 0.6 * kRelief);
  EXPECT_LT(deviation, 1.4 * kRelief);
}

TEST(Inflation, EveryShapeHasItsOwnFaces) {
  const Outline outline = wavy(1, 1, 0.05);
  const Mesh first = inflated(outline, 0.06, 0), again = inflated(outline, 0.06, 0),
             second = inflated(outline, 0.06, 1);
  double differs = 0;
  for (std::size_t i = 0; i < first.vertices.size(); ++i) {
    EXPECT_EQ(first.vertices[i], again.vertices[i]);
    differs = std::max(differs, (first.vertices[i] - second.vertices[i]).norm());
  }
  EXPECT_GT(differs, 0.02);
}

// An outline whose center lies outside still makes a closed body.
TEST(Inflation, FillsBays) {
  std::vector<Vec2> bow;
  for (int i = 0; i <= 100; ++i) bow.emplace_back(2 * std::cos(pi * i / 100), 2 * std::sin(pi * i / 100));
  for (int i = 100; i >= 0; --i) bow.emplace_back(1.7 * std::cos(pi * i / 100), 1.7 * std::sin(pi * i / 100));
  const Mesh mesh = inflated(make_outline(1, bow, 180), 0.06);
  EXPECT_GT(mesh_volume(mesh), 0);
  for (const Vec3& v : mesh.vertices) EXPECT_TRUE(v.allFinite());
}

}  // namespace
}  // namespace terrazzo
