#include <gtest/gtest.h>

#include "nodes/data/table.h"
#include "nodes/shapes/shape/rock.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/study/shape_observer/observer.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape;

using shape_observer::observe;

TEST(ShapeObserver, CannotTellAShapeFromItself) {
  const Shapes rock = test::one_shape(rock_mesh({}));
  double told = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) told += observe(rock, rock, {10, 180, seed, 64}).told / 4;
  // 720 pairs: a standard error of 1.9 %.
  EXPECT_NEAR(told, 0.5, 0.08);
}

TEST(ShapeObserver, TellsABallFromABox) {
  const auto v = observe(test::one_shape(ellipsoid_mesh({1, 1, 1}, 2)), test::one_shape(box_mesh({1, 1, 1})),
                         {5, 90, 1, 64});
  EXPECT_GT(v.told, 0.99);
  EXPECT_FALSE(v.by.empty());
}

TEST(ShapeObserver, SeesMoreInMoreProfiles) {
  const Shapes a = test::one_shape(box_mesh({1, 1, 1})), b = test::one_shape(box_mesh({1.25, 1, 1}));
  EXPECT_GT(observe(a, b, {60, 90, 1, 64}).told, observe(a, b, {1, 180, 1, 64}).told + 0.1);
}

TEST(ShapeObserver, IsTheSameOnAnyNumberOfThreads) {
  const Value a = Value::of(test::one_shape(box_mesh({1, 1, 1}))),
              b = Value::of(test::one_shape(box_mesh({1.1, 1, 1})));
  const std::map<std::string, std::string> few{{"profiles", "3"}, {"views", "45"}};
  const auto x = test::run_node("ShapeObserver", {{"shapes", a}, {"shapes", b}}, few, {}, 1),
             y = test::run_node("ShapeObserver", {{"shapes", a}, {"shapes", b}}, few, {}, 5);
  EXPECT_EQ(x.output<Table>("table").rows, y.output<Table>("table").rows);
}

TEST(ShapeObserver, BadInputIsNamed) {
  const Value a = Value::of(test::one_shape(box_mesh({1, 1, 1})));
  EXPECT_EQ(test::code_of([&] { test::run_node("ShapeObserver", {{"shapes", a}}); }), "no-decoys");
  EXPECT_EQ(test::code_of([&] {
              test::run_node("ShapeObserver", {{"shapes", a}, {"shapes", Value::of(Shapes{})}},
                             {{"views", "18"}, {"profiles", "1"}});
            }),
            "no-shapes");
}

}  // namespace
}  // namespace terrazzo
