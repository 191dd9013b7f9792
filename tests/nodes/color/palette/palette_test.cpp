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

TEST(Palette, EveryColorHasItsClass) {
  const std::string two = "[\"#ffffff\", \"#000000\"]";
  const auto run = test::run_node("Palette", {}, {{"colors", two}, {"classes", "[2, 0]"}});
  const Profiles& p = run.output<Profiles>("profiles");
  EXPECT_EQ(p.profiles[0].cls, 2);
  EXPECT_EQ(p.profiles[1].cls, 0);
  EXPECT_EQ(p.classes, 3);
  EXPECT_THROW(test::run_node("Palette", {}, {{"colors", two}, {"classes", "[0, 1, 2]"}}), Error);
}

TEST(Palette, RefusesWhatIsNoColor) {
  EXPECT_THROW(test::run_node("Palette", {}, {{"colors", "[red]"}}), Error);
  EXPECT_THROW(
      test::run_node("Palette", {}, {{"colors", "[\"#ffffff\", \"#000000\"]"}, {"shares", "[1, 2, 3]"}}),
      Error);
}

}  // namespace
}  // namespace terrazzo
