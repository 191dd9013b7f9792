// The directions in which stones lie.
#include "nodes/packing/pack/fabric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/packing/rigid/lying.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using std::numbers::pi;

Profile stone(double direction, double ratio = 0.5) {
  Profile p;
  for (int i = 0; i < 60; ++i) {
    const double t = 2 * pi * i / 60;
    p.contour.push_back(Eigen::Rotation2Dd(direction) * Vec2(2 * std::cos(t), 2 * ratio * std::sin(t)) +
                        Vec2(5, 5));
  }
  p.area = p.whole = 4 * pi * ratio;
  return p;
}

TEST(Fabric, FindsTheDirectionsOfAlignedStones) {
  Profiles p;
  p.view = View::Surface;
  Random random(1);
  for (int k = 0; k < 40; ++k) p.profiles.push_back(stone(0.7 + 0.3 * random.normal() + (k % 2) * pi));
  p.profiles.push_back(stone(2, 0.95));  // as wide as long
  p.profiles.push_back(stone(2));        // half hidden
  p.profiles.back().whole *= 2;
  p.profiles.push_back(stone(2));  // cut by the border
  p.profiles.back().touches_border = true;
  const auto axes = pack::long_axes(p);
  ASSERT_EQ(axes.size(), 40u);
  Vec2 sum = Vec2::Zero();
  for (const double a : axes) sum += Vec2(std::cos(2 * a), std::sin(2 * a)) / axes.size();
  EXPECT_NEAR(std::atan2(sum.y(), sum.x()) / 2, 0.7, 0.1);
}

TEST(Fabric, StonesInAllDirectionsHaveNone) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Profiles p;
    Random random(seed);
    for (int k = 0; k < 60; ++k) p.profiles.push_back(stone(random.uniform(0, pi)));
    found += !pack::long_axes(p).empty();
  }
  EXPECT_LE(found, 3);
  EXPECT_TRUE(pack::long_axes({}).empty());
}

TEST(Fabric, LyingStonesPointThatWay) {
  Shapes shapes = test::run_node("Shape", {}, {{"kind", "sphere"}, {"size", "2"}}).output<Shapes>("shapes");
  for (Vec3& v : shapes.shapes[0].mesh.vertices) v = v.cwiseProduct(Vec3(1, 0.5, 2));  // long along z
  packing::Packing p;
  constexpr int kCount = 400;
  p.shape.assign(kCount, 0);
  p.position.assign(kCount, Vec3::Zero());
  p.orientation.assign(kCount, Quat::Identity());
  packing::lay_flat(p, shapes, 0, {0.4, 2}, 5);
  int near_first = 0, near_second = 0;
  for (const Quat& q : p.orientation) {
    const Vec3 axis = q * Vec3::UnitZ();
    const double direction = std::atan2(axis.y(), axis.x());
    const auto off = [&](double to) { return std::abs(std::sin(direction - to)); };
    near_first += off(0.4) < 0.25;
    near_second += off(2) < 0.25;
  }
  EXPECT_GT(near_first + near_second, 0.97 * kCount);
  EXPECT_GT(near_first, 0.4 * kCount);
  EXPECT_GT(near_second, 0.4 * kCount);
}

}  // namespace
}  // namespace terrazzo
