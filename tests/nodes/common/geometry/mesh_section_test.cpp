#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/common/geometry/directions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/convex_hull.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/profile_sweep.h"
#include "nodes/common/stereology/shape_measures.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

using std::numbers::pi;

Mat3 frame(const Vec3& u) {
  Mat3 f;
  f.col(2) = u, f.col(0) = u.unitOrthogonal(), f.col(1) = u.cross(f.col(0));
  return f;
}

Mesh hull_of_random_points(std::uint64_t seed, int n) {
  Random r(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) points.push_back(random_direction(r) * std::cbrt(r.uniform()));
  return convex_hull(points);
}

Mesh unit_cube() {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1, i >> 1 & 1, i >> 2 & 1);
  return convex_hull(corners);
}

// A bumpy closed surface of genus 0, or a ring of genus 1: non-convex, in general position.
Mesh bumpy(std::uint64_t seed, bool ring) {
  Random r(seed);
  const double a = r.uniform(2, 4), b = r.uniform(0, 6), c = r.uniform(2, 5), d = r.uniform(0, 6);
  constexpr int kAround = 24, kAcross = 16;
  Mesh m;
  for (int i = 0; i < kAround; ++i)
    for (int j = ring ? 0 : 1; j < kAcross; ++j) {
      const double u = 2 * pi * i / kAround, v = (ring ? 2 : 1) * pi * j / kAcross;
      const double bump = 1 + 0.25 * std::sin(std::round(a) * u + b) * std::sin(std::round(c) * v + d);
      if (ring)
        m.vertices.emplace_back((2 + 0.7 * bump * std::cos(v)) * std::cos(u),
                                (2 + 0.7 * bump * std::cos(v)) * std::sin(u), 0.7 * bump * std::sin(v));
      else
        m.vertices.push_back(bump * Vec3(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v)));
    }
  const int rows = ring ? kAcross : kAcross - 1;
  const auto at = [&](int i, int j) { return (i % kAround) * rows + j % rows; };
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j + (ring ? 0 : 1) < rows; ++j) {
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
      m.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  if (!ring) {
    const auto top = static_cast<std::int32_t>(m.vertices.size());
    m.vertices.emplace_back(0, 0, 1);
    m.vertices.emplace_back(0, 0, -1);
    for (int i = 0; i < kAround; ++i) {
      m.triangles.push_back({top, at(i, 0), at(i + 1, 0)});
      m.triangles.push_back({top + 1, at(i + 1, rows - 1), at(i, rows - 1)});
    }
  }
  if (mesh_volume(m) < 0)
    for (auto& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

TEST(Mesh, CubeMeasures) {
  Mesh m = unit_cube();
  EXPECT_EQ(mesh_faults(m), std::vector<std::string>{});
  EXPECT_NEAR(mesh_volume(m), 1, 1e-12);
  EXPECT_NEAR(mesh_surface_area(m), 6, 1e-12);
  EXPECT_NEAR((mesh_centroid(m) - Vec3(.5, .5, .5)).norm(), 0, 1e-12);
  EXPECT_NEAR(mesh_edge_curvature(m), 1.5, 1e-12);
  EXPECT_NEAR(mesh_mean_caliper(m), 1.5, 1e-9);
  transform(m, Vec3(-1, 2, 3).asDiagonal(), {100, 0, 0});
  EXPECT_NEAR(mesh_volume(m), 6, 1e-9);  // turned inside out by the mirroring, then corrected
  EXPECT_NEAR(mesh_mean_caliper(m), 3, 1e-9);
}

TEST(Mesh, FaultsNameThePlace) {
  Mesh m = unit_cube();
  m.triangles.pop_back();
  ASSERT_EQ(mesh_faults(m).size(), 3u);
  EXPECT_NE(mesh_faults(m)[0].find("has 1 triangle"), std::string::npos);
  m = unit_cube();
  std::swap(m.triangles[3][0], m.triangles[3][1]);
  EXPECT_FALSE(mesh_faults(m).empty());
  m = unit_cube();
  m.vertices[2].y() = std::nan("");
  EXPECT_FALSE(mesh_faults(m).empty());
  m.triangles[0] = {0, 1, 99};
  EXPECT_FALSE(mesh_faults(m).empty());
  EXPECT_FALSE(mesh_faults(Mesh()).empty());
}

TEST(Mesh, ConvexityIsSeen) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_TRUE(mesh_is_convex(hull_of_random_points(seed, 60)));
    EXPECT_FALSE(mesh_is_convex(bumpy(seed, false)));
    EXPECT_FALSE(mesh_is_convex(bumpy(seed, true)));
  }
  Mesh two = unit_cube();
  for (Triangle t : unit_cube().triangles) two.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  for (const Vec3& v : unit_cube().vertices) two.vertices.push_back(v + Vec3(2, 0, 0));
  EXPECT_FALSE(mesh_is_convex(two));
}

TEST(ConvexHull, HoldsItsPointsAndIsConvex) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Mesh hull = hull_of_random_points(seed, 200);
    EXPECT_EQ(mesh_faults(hull), std::vector<std::string>{});
    EXPECT_TRUE(mesh_is_convex(hull));
    EXPECT_EQ(hull.vertices.size() + hull.triangles.size() - hull.triangles.size() * 3 / 2, 2u);
    Random r(seed);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = random_direction(r) * std::cbrt(r.uniform());
      for (const auto& t : hull.triangles) {
        const Vec3 n =
            (hull.vertices[t[1]] - hull.vertices[t[0]]).cross(hull.vertices[t[2]] - hull.vertices[t[0]]);
        ASSERT_LE(n.normalized().dot(p - hull.vertices[t[0]]), 1e-8);
      }
    }
  }
}

TEST(ConvexHull, PointsOnFacesAndEdgesDoNotMatter) {
  std::vector<Vec3> grid;
  const Mat3 turn = Quat(.3, .5, .1, .7).normalized().toRotationMatrix();
  for (int i = 0; i <= 8; ++i)
    for (int j = 0; j <= 8; ++j)
      for (int k = 0; k <= 8; ++k) grid.push_back(turn * Vec3(i, j, k) / 8);
  const Mesh hull = convex_hull(grid);
  EXPECT_EQ(mesh_faults(hull), std::vector<std::string>{});
  EXPECT_NEAR(mesh_edge_curvature(hull), 1.5, 1e-7);
  EXPECT_NEAR(mesh_volume(hull), 1, 1e-7);
}

TEST(ConvexHull, FlatPointsAreRefused) {
  EXPECT_THROW(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), Error);
  EXPECT_THROW(convex_hull({}), Error);
  EXPECT_THROW(convex_hull(std::vector<Vec3>(10, Vec3(1, 2, 3))), Error);
}

TEST(MeshSection, CubeAcrossItsMiddle) {
  const auto square = section_loops(unit_cube(), Mat3::Identity(), 0.5);
  ASSERT_EQ(square.size(), 1u);
  EXPECT_NEAR(loop_area(square[0]), 1, 1e-12);
  EXPECT_NEAR(loop_perimeter(square[0]), 4, 1e-12);
  const auto hexagon = section_loops(unit_cube(), frame(Vec3(1, 1, 1).normalized()), 1.5 / std::sqrt(3.0));
  ASSERT_EQ(hexagon.size(), 1u);
  EXPECT_NEAR(loop_area(hexagon[0]), 0.75 * std::sqrt(3.0), 1e-12);
  EXPECT_TRUE(section_loops(unit_cube(), Mat3::Identity(), 1.1).empty());
  EXPECT_TRUE(section_loops(unit_cube(), Mat3::Identity(), -0.1).empty());
}

TEST(MeshSection, PlanesThroughVerticesGiveClosedLoops) {
  // Faces, edges and corners exactly in the plane: vertices on the plane count as above it.
  EXPECT_NEAR(loop_area(section_loops(unit_cube(), Mat3::Identity(), 1)[0]), 1, 1e-12);
  EXPECT_TRUE(section_loops(unit_cube(), Mat3::Identity(), 0).empty());
  const auto diagonal = section_loops(unit_cube(), frame(Vec3(1, -1, 0).normalized()), 0);
  ASSERT_EQ(diagonal.size(), 1u);
  EXPECT_NEAR(loop_area(diagonal[0]), std::sqrt(2.0), 1e-12);
}

TEST(MeshSection, VolumeSurfaceAndEulerFromRandomSections) {
  // Means over directions: ∫ A dh = V in each; ∫χ dh = (1/4π) Σ Lθ; ∫ perimeter dh = πS/4.
  for (const bool ring : {false, true}) {
    const Mesh m = bumpy(7, ring);
    Random r(11);
    const int directions = 120, depths = 60;
    double volume = 0, perimeter = 0, euler = 0;
    for (int i = 0; i < directions; ++i) {
      const Vec3 u = random_direction(r);
      double lo = 1e9, hi = -1e9;
      for (const Vec3& v : m.vertices) {
        lo = std::min(lo, u.dot(v));
        hi = std::max(hi, u.dot(v));
      }
      const double step = (hi - lo) / depths, shift = r.uniform();
      for (int k = 0; k < depths; ++k)
        for (const Loop& l : section_loops(m, frame(u), lo + (k + shift) * step)) {
          const double area = loop_area(l);
          volume += step * area;
          perimeter += step * loop_perimeter(l);
          euler += area > 0 ? step : -step;
        }
    }
    EXPECT_NEAR(volume / directions / mesh_volume(m), 1, 0.01);
    EXPECT_NEAR(perimeter / directions / (pi * mesh_surface_area(m) / 4), 1, 0.02);
    EXPECT_NEAR(euler / directions / mesh_edge_curvature(m), 1, 0.03);
  }
}

TEST(MeshSection, HolesGoWithTheirProfile) {
  const Mesh m = bumpy(3, true);
  const auto profiles = section_profiles(section_loops(m, Mat3::Identity(), 0.03));
  ASSERT_EQ(profiles.size(), 1u);
  ASSERT_EQ(profiles[0].size(), 2u);
  EXPECT_GT(loop_area(profiles[0][0]), 0);
  EXPECT_LT(loop_area(profiles[0][1]), 0);
  EXPECT_EQ(section_profiles(section_loops(m, frame(Vec3(1, 0, 0)), 0.03)).size(), 2u);
}

TEST(ProfileSweep, AgreesWithSlicesOfRandomBodies) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Mesh m = bumpy(seed, seed % 2 == 0);
    ProfileSweep sweep(m);
    DepthSweep all(m);
    Random r(seed, 5);
    for (int i = 0; i < 6; ++i) {
      const Vec3 u = random_direction(r);
      double volume = 0, total = 0, count = 0, holes = 0;
      for (const ProfileRange& p : sweep.sweep(u)) {
        volume += p.area.thickness * (p.area.low + 4 * p.area.middle + p.area.high) / 6;
        count += p.area.thickness;
        holes += p.area.thickness * p.holes;
      }
      for (const AreaRange& a : all.sweep(u)) total += a.thickness * (a.low + 4 * a.middle + a.high) / 6;
      EXPECT_NEAR(volume, mesh_volume(m), 1e-7);
      EXPECT_NEAR(total, mesh_volume(m), 1e-7);
      double lo = 1e9, hi = -1e9;
      for (const Vec3& v : m.vertices) {
        lo = std::min(lo, u.dot(v));
        hi = std::max(hi, u.dot(v));
      }
      const int depths = 300;
      double sliced = 0, sliced_holes = 0;
      for (int k = 0; k < depths; ++k)
        for (const auto& p :
             section_profiles(section_loops(m, frame(u), lo + (k + 0.5) * (hi - lo) / depths)))
          sliced += (hi - lo) / depths,
              sliced_holes += (hi - lo) / depths * static_cast<double>(p.size() - 1);
      EXPECT_NEAR(count, sliced, 0.012 * (hi - lo)) << seed << " " << i;
      EXPECT_NEAR(holes, sliced_holes, 0.012 * (hi - lo)) << seed << " " << i;
    }
  }
}

TEST(ProfileSweep, EulerNumberGivesTheEdgeCurvature) {
  for (const bool ring : {false, true}) {
    const Mesh m = bumpy(5, ring);
    ProfileSweep sweep(m);
    Random r(3);
    double sum = 0;
    const int n = 3000;
    for (int i = 0; i < n; ++i)
      for (const ProfileRange& p : sweep.sweep(random_direction(r))) sum += p.area.thickness * (1 - p.holes);
    EXPECT_NEAR(sum / n / mesh_edge_curvature(m), 1, 0.015);
  }
}

TEST(MaxSection, ClosedForms) {
  EXPECT_NEAR(max_section_area(unit_cube()), std::sqrt(2.0), 1e-5);
  Mesh box = unit_cube();
  transform(box, Vec3(1, 2, 3).asDiagonal(), {4, 5, 6});
  EXPECT_NEAR(max_section_area(box) / (3 * std::sqrt(5.0)), 1, 1e-5);
  const double q = 1 / std::sqrt(8.0);
  EXPECT_NEAR(max_section_area(convex_hull({{q, q, q}, {q, -q, -q}, {-q, q, -q}, {-q, -q, q}})),
              std::sqrt(3.0) / 4, 1e-5);
}

TEST(MaxSection, NoSliceIsLarger) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Mesh m = seed % 2 ? hull_of_random_points(seed, 40) : bumpy(seed, false);
    const double most = max_section_area(m);
    Random r(seed, 9);
    for (int i = 0; i < 400; ++i) {
      double area = 0;
      for (const Loop& l : section_loops(m, frame(random_direction(r)), r.uniform(-0.4, 0.4)))
        area += loop_area(l);
      ASSERT_LE(area, most * (1 + 1e-3));
    }
  }
}

TEST(MeshSection, ManyPlanesGiveTheLoopsOfEachToTheBit) {
  int disjoint = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    for (const Mesh& m :
         {bumpy(seed, false), bumpy(seed, true), hull_of_random_points(seed, 60), unit_cube()}) {
      MeshCutter cutter(m);
      Random r(seed, 7);
      for (int i = 0; i < 40; ++i) {
        const Mat3 f = frame(random_direction(r));
        if (i % 3) {
          const auto [low, high] = cutter.turn(f.col(2));
          double lowest = 1e300;
          for (const Vec3& v : m.vertices) lowest = std::min(lowest, f.col(2).dot(v));
          EXPECT_NEAR(low, lowest, 1e-12);
          EXPECT_LT(low, high);
        }
        const double h = i % 5 ? r.uniform(-1, 1) : f.col(2).dot(m.vertices[0]);  // also through a vertex
        const auto one = section_loops(m, f, h), many = cutter.loops(f, h);
        ASSERT_EQ(one.size(), many.size());
        for (std::size_t k = 0; k < one.size(); ++k) EXPECT_EQ(one[k], many[k]);
        disjoint += one.size() > 1;
      }
    }
  EXPECT_GT(disjoint, 10);
}

TEST(MeasureShape, CentersAndRefuses) {
  const Shape s = measure_shape("cube", unit_cube(), 0.5);
  EXPECT_NEAR(mesh_centroid(s.mesh).norm(), 0, 1e-12);
  EXPECT_EQ(s.probability, 0.5);
  const auto code = [](Mesh m) { return test::code_of([&] { measure_shape("bad", std::move(m)); }); };
  Mesh m = unit_cube();
  m.triangles.pop_back();
  EXPECT_EQ(code(m), "open-mesh");
  m = unit_cube();
  for (auto& t : m.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(code(m), "no-volume");
  EXPECT_EQ(code({}), "open-mesh");
}

TEST(MeasureShape, ProbabilitiesSumToOne) {
  Shapes shapes;
  shapes.shapes.resize(2);
  shapes.shapes[0].probability = 3;
  shapes.shapes[1].probability = 1;
  normalize_probabilities(shapes);
  EXPECT_DOUBLE_EQ(shapes.shapes[0].probability, 0.75);
  shapes.shapes[0].probability = -1;
  EXPECT_THROW(normalize_probabilities(shapes), Error);
  shapes.shapes[0].probability = shapes.shapes[1].probability = 0;
  EXPECT_THROW(normalize_probabilities(shapes), Error);
}

}  // namespace
}  // namespace terrazzo
