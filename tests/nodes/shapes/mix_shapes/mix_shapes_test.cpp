#include "nodes/shapes/mix_shapes/mix_shapes.h"
#include "tests/support/code_of.h"

#include <gtest/gtest.h>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

Shapes set(std::vector<double> probabilities) {
  Shapes s;
  for (const double p : probabilities) s.shapes.emplace_back().probability = p;
  return s;
}

TEST(MixShapes, SharesAreDividedByTheSetsOwnProbabilities) {
  const Shapes a = set({1, 3}), b = set({5});
  const Shapes all = mix_shapes::mix({&a, &b}, {2, 6});
  ASSERT_EQ(all.shapes.size(), 3u);
  EXPECT_DOUBLE_EQ(all.shapes[0].probability, 0.25 * 0.25);
  EXPECT_DOUBLE_EQ(all.shapes[1].probability, 0.25 * 0.75);
  EXPECT_DOUBLE_EQ(all.shapes[2].probability, 0.75);
}

TEST(MixShapes, BadSharesAreNamed) {
  const Shapes a = set({1}), b = set({1});
  const auto code = [&](const std::vector<double>& shares) {
    return test::code_of([&] { mix_shapes::mix({&a, &b}, shares); });
  };
  EXPECT_EQ(code({1, 2}), "");
  EXPECT_EQ(code({1}), "wrong-count");
  EXPECT_EQ(code({1, -1}), "bad-probabilities");
  EXPECT_EQ(code({0, 0}), "bad-probabilities");
}

}  // namespace
}  // namespace terrazzo
