#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "nodes/shapes/shape/rock.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/shapes/shape_metrics/metrics.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape;

using std::numbers::pi;

const std::map<std::string, std::string> few{{"sections", "400"}};

TEST(ShapeMetrics, OfABall) {
  const auto run = test::run_node(
      "ShapeMetrics", {{"shapes", Value::of(test::one_shape(ellipsoid_mesh({1, 1, 1}, 3)))}}, few);
  const auto& t = run.output<Table>("table");
  ASSERT_EQ(t.rows.size(), 2u);
  for (std::size_t row = 0; row < 2; ++row) {
    EXPECT_NEAR(t.number(row, "area/perimeter² mean"), 1 / (4 * pi), 2e-3);
    EXPECT_NEAR(t.number(row, "total curvature rad mean"), 2 * pi, 1e-6);
    EXPECT_EQ(t.number(row, "profiles"), 400);
  }
  EXPECT_LT(t.number(0, "area/perimeter² sd"), 1e-3);
}

// The total curvature of any section of a convex body is 2π.
TEST(ShapeMetrics, ConvexBodiesTurnOnce) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RockOptions o;
    o.seed = seed, o.roughness = 0, o.chips = 0;
    const auto s =
        shape_metrics::summarize(test::one_shape(rock_mesh(o)), SectionKind::Random, {300, seed, {}});
    EXPECT_NEAR(s.mean[1], 2 * pi, 0.02);
    EXPECT_GT(s.mean[static_cast<std::size_t>(OutlineFeature::Convexity)], 0.999);
  }
}

TEST(ShapeMetrics, SectionsOfACubeThroughItsCenter) {
  // Squares, rectangles up to 1 × √2, and hexagons in between.
  const auto s =
      shape_metrics::summarize(test::one_shape(box_mesh({1, 1, 1})), SectionKind::Central, {4000, 1, {}});
  EXPECT_GT(s.mean[0], 1.0 / 17.5);
  EXPECT_LT(s.mean[0], std::sqrt(3.0) / 24);
  EXPECT_NEAR(s.mean[6], 1, 0.3);
}

TEST(ShapeMetrics, RowsAreComparedWithTheFirst) {
  const Value cube = Value::of(test::one_shape(box_mesh({1, 1, 1}))),
              slab = Value::of(test::one_shape(box_mesh({4, 4, 1})));
  auto parameters = few;
  parameters["names"] = "[cube, slab, again]";
  const auto run =
      test::run_node("ShapeMetrics", {{"shapes", cube}, {"shapes", slab}, {"shapes", cube}}, parameters);
  const auto& t = run.output<Table>("table");
  ASSERT_EQ(t.rows.size(), 6u);
  EXPECT_EQ(std::get<std::string>(t.rows[1][0]), "slab");
  EXPECT_LT(t.number(1, "area/perimeter² deviation %"), -5);
  EXPECT_EQ(t.number(2, "area/perimeter² deviation %"), 0);
  EXPECT_EQ(t.number(5, "aspect deviation %"), 0);
}

TEST(ShapeMetrics, SetsAreWeighted) {
  Shapes both = test::one_shape(box_mesh({1, 1, 1}));
  both.shapes.push_back(measure_shape("ball", ellipsoid_mesh({1, 1, 1}, 2)));
  both.shapes[0].probability = 0;
  both.shapes[1].probability = 1;
  auto parameters = few;
  parameters["rows"] = "set";
  const auto run = test::run_node("ShapeMetrics", {{"shapes", Value::of(both)}}, parameters);
  EXPECT_EQ(run.output<Table>("table").rows.size(), 2u);
  EXPECT_NEAR(run.metrics.at("circularity_central"), 1 / (4 * pi), 3e-3);
}

TEST(ShapeMetrics, IsTheSameOnAnyNumberOfThreads) {
  const Value body = Value::of(test::one_shape(box_mesh({1, 2, 3})));
  const auto a = test::run_node("ShapeMetrics", {{"shapes", body}}, {{"sections", "1500"}}, {}, 1);
  const auto b = test::run_node("ShapeMetrics", {{"shapes", body}}, {{"sections", "1500"}}, {}, 5);
  EXPECT_EQ(a.output<Table>("table").rows, b.output<Table>("table").rows);
}

TEST(ShapeMetrics, BadInputIsNamed) {
  EXPECT_EQ(test::code_of([] {
              test::run_node("ShapeMetrics", {{"shapes", Value::of(Shapes{})}});
            }),
            "no-shapes");
  Shapes open = test::one_shape(box_mesh({1, 1, 1}));
  open.shapes[0].mesh.triangles.pop_back();
  EXPECT_EQ(test::code_of([&] {
              test::run_node("ShapeMetrics", {{"shapes", Value::of(open)}});
            }),
            "open-mesh");
  EXPECT_EQ(test::code_of([&] {
              test::run_node("ShapeMetrics", {{"shapes", Value::of(test::one_shape(box_mesh({1, 1, 1})))}},
                             {{"names", "[a, b]"}});
            }),
            "bad-names");
}

}  // namespace
}  // namespace terrazzo
