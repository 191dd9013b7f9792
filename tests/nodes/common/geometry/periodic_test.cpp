#include "nodes/common/geometry/periodic.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "runtime/random.h"

namespace terrazzo {
namespace {

Vec3 any_point(Random& r, double from, double to) {
  return {r.uniform(from, to), r.uniform(from, to), r.uniform(from, to)};
}

// The least distance of two points over all images near the box.
double least_distance(const Vec3& a, const Vec3& b, const Vec3& box) {
  double least = 1e300;
  for (int z = -3; z <= 3; ++z)
    for (int y = -3; y <= 3; ++y)
      for (int x = -3; x <= 3; ++x) least = std::min(least, (b - a + Vec3(x, y, z).cwiseProduct(box)).norm());
  return least;
}

TEST(Periodic, IndicesRepeat) {
  for (int n : {1, 2, 7})
    for (int i = -30; i < 30; ++i) {
      const int w = wrap_index(i, n);
      EXPECT_GE(w, 0);
      EXPECT_LT(w, n);
      EXPECT_EQ((i - w) % n, 0);
    }
}

TEST(Periodic, PointsMoveByWholeEdgesIntoTheBox) {
  Random r(1);
  const Vec3 box(1.3, 0.7, 2.9);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = any_point(r, -9, 9), q = wrap_point(p, box);
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(q[a], 0);
      EXPECT_LT(q[a], box[a]);
      const double edges = (p[a] - q[a]) / box[a];
      EXPECT_NEAR(edges, std::round(edges), 1e-12);
    }
    EXPECT_EQ(wrap_point(q, box), q);
  }
  EXPECT_EQ(wrap_point(Vec3(-1e-18, 0.7, 2.9), box), Vec3(0, 0, 0));
}

TEST(Periodic, NearestImageIsTheShortestDifference) {
  Random r(2);
  const Vec3 box(1.3, 0.7, 2.9);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 a = wrap_point(any_point(r, 0, 9), box), b = wrap_point(any_point(r, 0, 9), box);
    EXPECT_NEAR(nearest_image(b - a, box).norm(), least_distance(a, b, box), 1e-12);
  }
}

// Whatever is within reach of a point is in a cell that is visited, and no cell is visited twice.
TEST(Periodic, CellsWithinReachAreVisitedOnce) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random r(seed);
    const Vec3 box = any_point(r, 0.5, 3);
    const PeriodicCells cells(box, r.uniform(0.1, 1.5), 8);
    EXPECT_LE(cells.cells.maxCoeff(), 8);
    std::vector<Vec3> points;
    for (int k = 0; k < 200; ++k) points.push_back(any_point(r, 0, 1).cwiseProduct(box));
    for (int k = 0; k < 20; ++k) {
      const Vec3 p = any_point(r, 0, 1).cwiseProduct(box);
      const double reach = r.uniform(0, 1) * box.minCoeff();
      std::set<std::size_t> seen;
      cells.visit(p, reach, [&](std::size_t cell) {
        EXPECT_LT(cell, cells.count());
        EXPECT_TRUE(seen.insert(cell).second);
      });
      for (const Vec3& q : points)
        if (least_distance(p, q, box) < reach) {
          EXPECT_TRUE(seen.count(cells.at(q))) << seed;
        }
      if (reach < 1e-3 * box.minCoeff()) {
        EXPECT_LE(seen.size(), 8u);
      }
    }
  }
}

}  // namespace
}  // namespace terrazzo
