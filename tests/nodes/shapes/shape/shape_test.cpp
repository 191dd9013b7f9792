#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/shapes.h"
#include "nodes/shapes/shape/closed_form.h"
#include "nodes/shapes/shape/rock.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/shapes/shape/wear.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape;

using std::numbers::pi;

int euler(const Mesh& m) {
  return static_cast<int>(m.vertices.size()) - static_cast<int>(m.triangles.size()) * 3 / 2 +
         static_cast<int>(m.triangles.size());
}

TEST(ShapeSolids, PlatonicSolidsHaveTheirMeasures) {
  const double caliper[] = {.9122602, 1.1754797, 2.6431229, 1.7420965};
  const SolidKind kinds[] = {SolidKind::Tetrahedron, SolidKind::Octahedron, SolidKind::Dodecahedron,
                             SolidKind::Icosahedron};
  const int faces[] = {4, 8, 36, 20};
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    const Mesh m = platonic_mesh(kinds[i]);
    const auto c = platonic_closed_form(kinds[i], 1);
    EXPECT_EQ(mesh_faults(m), std::vector<std::string>{});
    EXPECT_EQ(m.triangles.size(), faces[i]);
    EXPECT_EQ(euler(m), 2);
    EXPECT_NEAR(*c.mean_caliper, caliper[i], 1e-7);
    EXPECT_NEAR(mesh_mean_caliper(m), caliper[i], 1e-7);
    EXPECT_NEAR(mesh_volume(m), *c.volume, 1e-12);
    EXPECT_NEAR(mesh_surface_area(m), *c.surface_area, 1e-12);
    if (c.max_section_area) {
      EXPECT_NEAR(max_section_area(m), *c.max_section_area, 1e-5);
    }
  }
}

TEST(ShapeSolids, ClosedFormsOfEllipsoids) {
  // Semi-axes (2, 1, 1), (1, 2, 2) and (1, 0.8, 0.6)
  EXPECT_NEAR(*ellipsoid_closed_form({4, 2, 2}).mean_caliper, 2.7603460, 1e-7);
  EXPECT_NEAR(*ellipsoid_closed_form({2, 4, 4}).mean_caliper, 3.4183992, 1e-7);
  EXPECT_NEAR(*ellipsoid_closed_form({2, 1.6, 1.2}).mean_caliper, 1.6200600, 1e-7);
  EXPECT_NEAR(*ellipsoid_closed_form({1, 1, 1}).mean_caliper, 1, 1e-14);
  EXPECT_NEAR(*ellipsoid_closed_form({1, 1, 1}).surface_area, pi, 1e-13);
  // Needle and disk: R_G(0, 0, 1) = ½ and R_G(0, 1, 1) = π/4.
  EXPECT_NEAR(carlson_rg(1e-16, 1e-16, 1), 0.5, 1e-7);
  EXPECT_NEAR(carlson_rg(0, 1, 1), pi / 4, 1e-14);
}

TEST(ShapeSolids, SuperquadricVolumesMeetKnownSolids) {
  EXPECT_NEAR(*superquadric_closed_form({2, 4, 6}, 1, 1).volume, 4 * pi / 3 * 6, 1e-12);
  EXPECT_NEAR(*superquadric_closed_form({2, 2, 2}, 2, 2).volume, 4.0 / 3, 1e-12);
  EXPECT_NEAR(*superquadric_closed_form({2, 2, 2}, 0.01, 0.01).volume, 8, 0.01);
}

TEST(ShapeSolids, TessellationsConvergeToTheSolid) {
  double last = 1;
  for (int detail = 1; detail <= 4; ++detail) {
    const Mesh m = ellipsoid_mesh(Vec3::Ones(), detail);
    EXPECT_EQ(m.triangles.size(), 20u << (2 * detail));
    EXPECT_NEAR(mesh_volume(m), pi / 6, 1e-12);
    const double error = std::abs(mesh_mean_caliper(m) - 1);
    EXPECT_LT(error, last / 3.5);
    last = error;
  }
  const auto c = cylinder_closed_form({1, 1, 2});
  EXPECT_NEAR(mesh_mean_caliper(cylinder_mesh({1, 1, 2}, 4)), *c.mean_caliper, 1e-4);
  EXPECT_NEAR(mesh_volume(cylinder_mesh({1, 1, 2}, 0)), *c.volume, 1e-12);
}

TEST(ShapeSolids, SuperquadricsAreSoundOverAllExponents) {
  for (const double e1 : {0.1, 0.7, 1.0, 2.5})
    for (const double e2 : {0.1, 0.7, 1.0, 2.5})
      for (const int detail : {0, 2, 3}) {
        const Mesh m = superquadric_mesh({3, 2, 1}, e1, e2, detail);
        EXPECT_TRUE(mesh_faults(m).empty());
        EXPECT_EQ(euler(m), 2);
        EXPECT_NEAR(mesh_volume(m), *superquadric_closed_form({3, 2, 1}, e1, e2).volume, 1e-9);
      }
}

// Every triangle faces away from the center: star-shaped, so triangles cannot intersect.
bool star_shaped(const Mesh& m) {
  for (const auto& t : m.triangles)
    if (m.vertices[t[0]].dot(m.vertices[t[1]].cross(m.vertices[t[2]])) <= 0) return false;
  return true;
}

TEST(ShapeRock, EverySeedGivesASoundStone) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RockOptions o;
    o.seed = seed;
    o.item = seed % 3;
    const Mesh m = rock_mesh(o);
    SCOPED_TRACE(seed);
    EXPECT_TRUE(mesh_faults(m).empty());
    EXPECT_EQ(euler(m), 2);
    EXPECT_TRUE(star_shaped(m));
    EXPECT_GT(mesh_volume(m), 0.7);
    EXPECT_LT(m.triangles.size(), 1000u);
    EXPECT_GT(m.triangles.size(), 300u);
  }
}

TEST(ShapeRock, ExtremesOfTheParametersStaySound) {
  for (const int facets : {4, 30})
    for (const int chips : {0, 20})
      for (const double roughness : {0.0, 0.1})
        for (const int detail : {0, 5}) {
          RockOptions o{.seed = 7,
                        .item = 0,
                        .axes = Vec3(1, 0.3, 0.2),
                        .facets = facets,
                        .chips = chips,
                        .roughness = roughness,
                        .detail = detail};
          const Mesh m = rock_mesh(o);
          EXPECT_TRUE(mesh_faults(m).empty());
          EXPECT_TRUE(star_shaped(m));
          EXPECT_EQ(euler(m), 2);
        }
}

TEST(ShapeNode, SizeIsTheDiameterOfTheLargestSection) {
  for (const char* kind : {"sphere", "ellipsoid", "box", "cylinder", "tetrahedron", "octahedron",
                           "dodecahedron", "icosahedron", "superquadric", "rock"}) {
    SCOPED_TRACE(kind);
    const std::string axes = std::string(kind) == "sphere" ? "[1, 1, 1]" : "[3, 2, 1.5]";
    const auto run =
        test::run_node("Shape", {}, {{"kind", kind}, {"size", "4"}, {"axes", axes}, {"detail", "2"}});
    const auto& s = run.output<Shapes>("shapes").shapes.at(0);
    EXPECT_NEAR(s.size(), 4, 1e-9);
    EXPECT_NEAR(max_section_area(s.mesh), pi / 4 * 16, 0.02 * 16);
    EXPECT_NEAR(mesh_volume(s.mesh), s.volume, 1e-9 * s.volume);
    EXPECT_NEAR(mesh_centroid(s.mesh).norm(), 0, 1e-9);
    EXPECT_EQ(s.probability, 1);
    EXPECT_EQ(s.name, kind);
  }
}

// The coordinates of a sphere of radius R are eigenfunctions of its Laplacian with eigenvalue 2/R².
TEST(ShapeWear, ShrinksASphereAsDiffusionDoes) {
  Mesh m = ellipsoid_mesh({4, 4, 4}, 4);
  const double radius = 2, edge = 0.4, variance = 2 / pi * edge * edge;
  round_edges(m, edge);
  for (const Vec3& v : m.vertices)
    EXPECT_NEAR(v.norm(), radius * std::pow(1 + variance / 4 / (radius * radius), -4), 2e-3);
}

double sharpest_edge(const Mesh& m) {
  std::map<std::pair<int, int>, Vec3> left;
  double least = 1;
  for (const Triangle& t : m.triangles) {
    const Vec3 n =
        (m.vertices[t[1]] - m.vertices[t[0]]).cross(m.vertices[t[2]] - m.vertices[t[0]]).normalized();
    for (int k = 0; k < 3; ++k) {
      const auto other = left.find({t[(k + 1) % 3], t[k]});
      if (other != left.end()) least = std::min(least, n.dot(other->second));
      left[{t[k], t[(k + 1) % 3]}] = n;
    }
  }
  return std::acos(least) * 180 / pi;
}

TEST(ShapeWear, RoundsEdgesAndKeepsStonesWhole) {
  for (const char* kind : {"rock", "shard", "clinker"}) {
    SCOPED_TRACE(kind);
    const auto stone = [&](const char* wear, const char* roughness) {
      return test::run_node("Shape", {},
                            {{"kind", kind}, {"detail", "5"}, {"wear", wear}, {"roughness", roughness}})
          .output<Shapes>("shapes")
          .shapes.at(0);
    };
    const Shape sharp = stone("0", "0"), worn = stone("0.1", "0"), rough = stone("0.1", "0.02");
    EXPECT_LT(sharpest_edge(worn.mesh), 0.5 * sharpest_edge(sharp.mesh));
    EXPECT_EQ(worn.mesh.triangles, sharp.mesh.triangles);
    EXPECT_EQ(mesh_faults(rough.mesh), std::vector<std::string>{});
    EXPECT_NEAR(worn.size(), 1, 1e-9);
    EXPECT_NE(rough.mesh.vertices, worn.mesh.vertices);
  }
}

TEST(ShapeNode, ClosedFormsAreReported) {
  const auto sphere = test::run_node("Shape", {}, {{"size", "3"}});
  const auto& s = sphere.output<Shapes>("shapes").shapes.at(0);
  EXPECT_DOUBLE_EQ(s.mean_caliper, 3);
  EXPECT_NEAR(s.volume, pi / 6 * 27, 1e-12);
  EXPECT_TRUE(s.smooth);
  // A cube of size √(4√2/π)·a has edge a.
  const auto cube = test::run_node(
      "Shape", {}, {{"kind", "box"}, {"size", std::to_string(std::sqrt(4 * std::sqrt(2) / pi))}});
  EXPECT_NEAR(cube.output<Shapes>("shapes").shapes.at(0).mean_caliper, 1.5, 1e-5);
  EXPECT_NEAR(cube.metrics.at("volume"), 1, 1e-5);
}

TEST(ShapeNode, SeveralRocksDifferAndRepeat) {
  const std::map<std::string, std::string> p{{"kind", "rock"}, {"count", "4"}, {"seed", "9"}};
  const auto a = test::run_node("Shape", {}, p, {}, 1), b = test::run_node("Shape", {}, p, {}, 2);
  const auto &x = a.output<Shapes>("shapes").shapes, &y = b.output<Shapes>("shapes").shapes;
  ASSERT_EQ(x.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(x[i].probability, 0.25);
    EXPECT_EQ(x[i].mesh.vertices, y[i].mesh.vertices);
    EXPECT_EQ(x[i].max_section_area, y[i].max_section_area);
    if (i) {
      EXPECT_NE(x[i].volume, x[0].volume);
    }
  }
}

TEST(ShapeNode, RefusesWhatMakesNoSolid) {
  const auto code = [](const std::map<std::string, std::string>& p) -> std::string {
    try {
      test::run_node("Shape", {}, p);
    } catch (const Error& e) {
      return e.diagnostic().parameter;
    }
    return "accepted";
  };
  EXPECT_EQ(code({{"kind", "sphere"}, {"axes", "[1, 2, 1]"}}), "axes");
  EXPECT_EQ(code({{"kind", "box"}, {"axes", "[1, 1, 1e9]"}}), "axes");
  EXPECT_EQ(code({{"kind", "box"}, {"count", "2"}}), "count");
  EXPECT_NE(code({{"kind", "box"}, {"axes", "[1, 0, 1]"}}), "accepted");
  EXPECT_NE(code({{"size", "0"}}), "accepted");
  EXPECT_NE(code({{"size", "nan"}}), "accepted");
}

}  // namespace
}  // namespace terrazzo
