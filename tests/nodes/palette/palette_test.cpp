#include <gtest/gtest.h>

#include "nodes/data/profiles.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

TEST(Palette, GivesColorsSharesAndBinder) {
  const auto run = test::run_node(
      "Palette", {}, {{"colors", "[\"#ffffff\", \"#000000\"]"}, {"shares", "[3, 1]"}, {"binder", "#ff0000"}});
  const Profiles& p = run.output<Profiles>("profiles");
  ASSERT_EQ(p.profiles.size(), 2u);
  EXPECT_EQ(p.profiles[0].color, Vec3f(1, 1, 1));
  EXPECT_EQ(p.profiles[0].weight, 3);
  EXPECT_EQ(p.profiles[1].color, Vec3f(0, 0, 0));
  EXPECT_EQ(p.binder_color, Vec3f(1, 0, 0));
}

TEST(Palette, RefusesWhatIsNoColor) {
  EXPECT_THROW(test::run_node("Palette", {}, {{"colors", "[red]"}}), Error);
  EXPECT_THROW(
      test::run_node("Palette", {}, {{"colors", "[\"#ffffff\", \"#000000\"]"}, {"shares", "[1, 2, 3]"}}),
      Error);
}

}  // namespace
}  // namespace terrazzo
