#include "nodes/common/geometry/mesh/loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/random.h"

namespace terrazzo {
namespace {

// A star-shaped polygon around `center`, counterclockwise.
Loop star(Random& r, const Vec2& center, int n) {
  Loop out;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * (i + 0.8 * r.uniform()) / n;
    out.push_back(center + r.uniform(0.3, 1) * Vec2(std::cos(a), std::sin(a)));
  }
  return out;
}

// A polygon has the area of its triangles around a center from which all of it is seen, and contains a point
// if and only if one of them does.
TEST(Loops, AreaAndInside) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random r(seed);
    const Vec2 c(r.uniform(-3, 3), r.uniform(-3, 3));
    Loop loop = star(r, c, 5 + static_cast<int>(r.below(20)));
    const std::size_t n = loop.size();
    double area = 0, around = 0, turned = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 &a = loop[i], &b = loop[(i + 1) % n], &d = loop[(i + 2) % n];
      area += cross(a - c, b - c) / 2;
      around += (b - a).norm();
      turned += turn_between(b - a, d - b);
    }
    EXPECT_NEAR(loop_area(loop), area, 1e-12);
    EXPECT_NEAR(loop_perimeter(loop), around, 1e-12);
    EXPECT_NEAR(turned, 2 * std::numbers::pi, 1e-9);
    for (int k = 0; k < 200; ++k) {
      const Vec2 p = c + Vec2(r.uniform(-1, 1), r.uniform(-1, 1));
      bool inside = false;
      for (std::size_t i = 0; i < n; ++i) {
        const Vec2 &a = loop[i], &b = loop[(i + 1) % n];
        inside |= cross(a - c, p - c) >= 0 && cross(p - c, b - c) >= 0 && cross(b - a, p - a) >= 0;
      }
      EXPECT_EQ(loop_contains(loop, p), inside);
    }
    std::reverse(loop.begin(), loop.end());
    EXPECT_NEAR(loop_area(loop), -area, 1e-12);
    EXPECT_TRUE(loop_contains(loop, c));
  }
}

// The hull contains all points, so it is no smaller than any polygon of them; points within add nothing.
TEST(Loops, AreaOfTheHull) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random r(seed, 1);
    const Loop loop = star(r, Vec2(2, -1), 30);
    const double hull = hull_area(loop);
    EXPECT_GT(hull, loop_area(loop));
    Loop more = loop;
    for (std::size_t i = 1; i + 1 < loop.size(); ++i) more.push_back((loop[i] + loop[i + 1] + loop[0]) / 3);
    EXPECT_EQ(hull_area(more), hull);
    std::shuffle(more.begin(), more.end(), r);
    EXPECT_EQ(hull_area(more), hull);
    more.push_back(Vec2(2, 5));
    EXPECT_GT(hull_area(more), hull + 1);
  }
  EXPECT_EQ(hull_area({{0, 0}, {4, 0}, {2, 1}, {4, 3}, {0, 3}, {2, 0}}), 12);
  EXPECT_EQ(hull_area({}), 0);
  EXPECT_EQ(hull_area({{1, 2}, {3, 4}, {5, 6}}), 0);
}

}  // namespace
}  // namespace terrazzo
