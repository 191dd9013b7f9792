// Bodies of crushed stones whose silhouette a photograph shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/profiles.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/relief.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape_estimate;
using std::numbers::pi;

// Corners at about equal angles on an ellipse, with points along the sides.
Loop fragment(Random& random, int corners) {
  Loop polygon;
  const double longer = random.uniform(1.2, 2);
  for (int k = 0; k < corners; ++k) {
    const double t = 2 * pi * (k + random.uniform(-0.25, 0.25)) / corners;
    polygon.emplace_back(longer * std::cos(t), std::sin(t));
  }
  Loop loop;
  constexpr int kPoints = 20;
  for (int k = 0; k < corners; ++k)
    for (int i = 0; i < kPoints; ++i)
      loop.push_back(polygon[k] + (polygon[(k + 1) % corners] - polygon[k]) * i / kPoints);
  return loop;
}

Loop smooth_stone(double a, double b) {
  Loop loop;
  for (int i = 0; i < 200; ++i)
    loop.emplace_back(a * std::cos(2 * pi * i / 200), b * std::sin(2 * pi * i / 200));
  return loop;
}

Mesh crushed_body(const Loop& loop, int index) {
  EstimateRequest request;
  request.chosen = {make_outline(1, loop, 25)};
  request.index = index;
  return faceted(request, {}).mesh;
}

TEST(Faceted, BodiesAreConvexAndHaveTheOutline) {
  Random random(11);
  constexpr int kBodies = 60;
  double mean = 0;  // of what body and outline share
  for (int k = 0; k < kBodies; ++k) {
    const Loop loop = fragment(random, 4 + static_cast<int>(random.below(5)));
    const Outline outline = make_outline(1, loop, 25);
    const Mesh mesh = crushed_body(loop, k);
    ASSERT_TRUE(mesh_faults(mesh).empty()) << k;
    EXPECT_GT(mesh_volume(mesh), 0) << k;
    EXPECT_TRUE(mesh_is_convex(mesh, 0.04)) << k;
    Loop shadow;
    for (const Vec3& v : mesh.vertices) shadow.emplace_back(v.head<2>());
    const Loop hull = hull_of(shadow);
    int both = 0, either = 0;
    for (double x = -2.5; x < 2.5; x += 0.05)
      for (double y = -2.5; y < 2.5; y += 0.05) {
        const bool in_body = loop_contains(hull, {x, y}), in_outline = loop_contains(outline.points, {x, y});
        both += in_body && in_outline;
        either += in_body || in_outline;
      }
    EXPECT_GT(both, 0.7 * either) << k;
    mean += static_cast<double>(both) / either / kBodies;
  }
  EXPECT_GT(mean, 0.85);
}

// Flat faces have few normals: a dozen belong to half of the surface, and to a tenth of a ball's.
TEST(Faceted, FacesAreFlat) {
  Random random(12);
  for (int k = 0; k < 20; ++k) {
    const Mesh mesh = crushed_body(fragment(random, 6), k);
    std::vector<std::pair<Vec3, double>> faces;  // and area
    double all = 0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3& a = mesh.vertices[t[0]];
      const Vec3 across = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a) / 2;
      const auto same = std::find_if(faces.begin(), faces.end(), [&](const auto& face) {
        return face.first.dot(across.normalized()) > 1 - 1e-9;
      });
      all += across.norm();
      if (same == faces.end())
        faces.emplace_back(across.normalized(), across.norm());
      else
        same->second += across.norm();
    }
    std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    double largest = 0;
    for (int i = 0; i < 12; ++i) largest += faces[i].second;
    EXPECT_GT(largest, 0.5 * all) << k;
  }
}

TEST(Faceted, EveryShapeHasItsOwnFaces) {
  Random random(13);
  const Loop loop = fragment(random, 6);
  const Mesh first = crushed_body(loop, 0), again = crushed_body(loop, 0), second = crushed_body(loop, 1);
  EXPECT_EQ(first.vertices, again.vertices);
  EXPECT_GT(std::abs(mesh_volume(first) - mesh_volume(second)), 1e-3);
}

TEST(Corners, TakeTheWholeTurnOfPolygonsAndNoneOfEllipses) {
  Random random(14);
  EXPECT_NEAR(usual_corners({make_outline(1, fragment(random, 5), 25)}), 1, 0.02);
  EXPECT_EQ(usual_corners({make_outline(1, smooth_stone(2, 1.3), 25)}), 0);
  EXPECT_EQ(usual_corners({}), 0);
}

TEST(Corners, TellCrushedStonesFromWornOnes) {
  for (const bool crushed : {false, true}) {
    Random random(15);
    Profiles p;
    p.view = View::Surface;
    for (int k = 0; k < 30; ++k) {
      Profile q;
      const bool broken = k >= (crushed ? 10 : 20);
      q.contour = broken ? fragment(random, 5) : smooth_stone(random.uniform(1.2, 2), 1);
      q.area = q.whole = loop_area(q.contour);
      p.profiles.push_back(q);
    }
    const auto run = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of<Profiles>(p)}},
                                              {{"method", "auto"}});
    for (const Shape& s : run.output<Shapes>("shapes").shapes) EXPECT_EQ(s.traced.faceted, crushed) << s.name;
    EXPECT_EQ(run.metrics.at("corners") > kCrushed, crushed);
  }
}

// Colors with smooth outlines among crushed stones have flat faces, too.
TEST(Corners, DecideForAllClassesTogether) {
  Random random(16);
  Profiles p;
  p.view = View::Surface;
  p.classes = 2;
  for (int k = 0; k < 60; ++k) {
    Profile q;
    q.cls = k >= 45;
    q.contour = q.cls == 0 ? fragment(random, 5) : smooth_stone(random.uniform(1.2, 2), 1);
    q.area = q.whole = loop_area(q.contour);
    p.profiles.push_back(q);
  }
  const auto run = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of<Profiles>(p)}},
                                            {{"method", "auto"}, {"class", "each"}});
  for (const Shape& s : run.output<Shapes>("shapes").shapes) EXPECT_TRUE(s.traced.faceted) << s.name;
}

}  // namespace
}  // namespace terrazzo
