#include "nodes/shapes/shape_cage/shape_cage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/table.h"
#include "tests/support/code_of.h"
#include "tests/support/german_locale.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace shape_cage;

// A sphere with bumps, of radius 0.75 to 1.25.
Mesh bumps() {
  Mesh out = geodesic_sphere(4);
  for (Vec3& v : out.vertices)
    v *= 1 + 0.25 * std::sin(3 * v.x() + 1) * std::cos(4 * v.y()) * std::sin(3 * v.z() + 2);
  return out;
}

TEST(ShapeCage, FitsTheShape) {
  const Mesh mesh = bumps();
  const Cage few = fit_cage(mesh, 30, 30), many = fit_cage(mesh, 120, 30);
  EXPECT_LT(few.control.vertices.size(), 36u);
  EXPECT_LT(few.mean_error, 0.03);  // of a diameter of 2
  EXPECT_LT(many.mean_error, 0.25 * few.mean_error);
  EXPECT_LT(many.largest_error, 0.04);
  // Without fitting, the surface of a reduced mesh shrinks.
  const Cage raw = fit_cage(mesh, 30, 0);
  EXPECT_GT(raw.mean_error, 2 * few.mean_error);
  EXPECT_NEAR(mesh_volume(limit_surface(many.control, 3)) / mesh_volume(mesh), 1, 0.005);
}

TEST(ShapeCage, TheErrorIsTheDistanceBothWays) {
  // A spike that the surface cannot reach counts, although every point of the surface is close to the mesh.
  Mesh mesh = geodesic_sphere(3);
  mesh.vertices[0] *= 1.5;
  const Cage cage = fit_cage(mesh, 12, 10);
  EXPECT_GT(cage.largest_error, 0.1);
}

TEST(ShapeCage, AMoveStaysLocal) {
  const Cage cage = fit_cage(bumps(), 60, 30);
  const Mesh before = limit_surface(cage.control, 3);
  Mesh control = cage.control;
  const Vec3 by(0.1, -0.2, 0.3);
  move_vertices(control, {{5, by}});
  const Mesh after = limit_surface(control, 3);
  double most = 0;
  std::size_t moved = 0;
  for (std::size_t v = 0; v < before.vertices.size(); ++v) {
    const Vec3 d = after.vertices[v] - before.vertices[v];
    EXPECT_LT((d - by * (d.dot(by) / by.squaredNorm())).norm(), 1e-12);  // only in this direction
    moved += d.norm() > 1e-12;
    most = std::max(most, d.norm() / by.norm());
  }
  EXPECT_GT(most, 0.4);  // a regular vertex of Loop subdivision has the limit weight 1/2
  EXPECT_LT(most, 0.7);
  EXPECT_GT(moved, 20u);
  EXPECT_LT(moved, before.vertices.size() / 2);
}

TEST(ShapeCage, ReplacesTheChosenShape) {
  Shapes shapes;
  shapes.shapes.push_back(measure_shape("first", bumps(), 0.3));
  shapes.shapes.push_back(measure_shape("second", geodesic_sphere(2), 0.7));
  const auto run = [&](const std::map<std::string, std::string>& p) {
    return test::run_node("ShapeCage", {{"shapes", Value::of(shapes)}}, p);
  };
  const auto same = run({{"shape", "1"}});
  const auto& out = same.output<Shapes>("shapes").shapes;
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].mesh.vertices, shapes.shapes[0].mesh.vertices);
  EXPECT_EQ(out[1].name, "second");
  EXPECT_EQ(out[1].probability, 0.7);
  EXPECT_NEAR(out[1].volume / shapes.shapes[1].volume, 1, 0.02);
  EXPECT_LT(same.metrics.at("mean_error"), 0.02);

  const auto moved = run({{"shape", "1"}, {"moves", "[\"0 0 0 0.5\"]"}});
  const auto &from = same.output<Table>("table"), &to = moved.output<Table>("table");
  EXPECT_NEAR(to.number(0, "z mm") - from.number(0, "z mm"), 0.5, 1e-12);
  EXPECT_EQ(to.number(1, "z mm"), from.number(1, "z mm"));
  EXPECT_NE(moved.output<Shapes>("shapes").shapes[1].volume, out[1].volume);

  const auto code = [&](const std::map<std::string, std::string>& p) {
    return test::code_of([&] { run(p); });
  };
  EXPECT_EQ(code({{"shape", "2"}}), "no-such-shape");
  EXPECT_EQ(code({{"moves", "[\"900 0 0 1\"]"}}), "bad-move");
  EXPECT_EQ(code({{"moves", "[\"0 0 1\"]"}}), "bad-move");
  EXPECT_EQ(code({{"moves", "[\"0 0 0 1 2\"]"}}), "bad-move");
}

TEST(ShapeCage, MovesDoNotDependOnTheLocale) {
  const test::GermanLocale german;
  const Move m = parse_move(" 1234 0.5  +1.5e0\t-2000.25 ");
  EXPECT_EQ(m.vertex, 1234);
  EXPECT_EQ(m.by, Vec3(0.5, 1.5, -2000.25));
  for (const char* wrong :
       {"", "1", "1 2 3", "1 2 3 4,5", "1 2 3 4 5", "1.5 0 0 0", "-1 0 0 0", "1 0 0 inf", "1 2 3 4x"})
    EXPECT_EQ(test::code_of([&] { parse_move(wrong); }), "bad-move") << wrong;
}

}  // namespace
}  // namespace terrazzo
