#include "nodes/common/geometry/mesh/mesh_distance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/geometry/directions.h"

namespace terrazzo {
namespace {

Vec3 point_around(Random& r, double reach) { return reach * std::cbrt(r.uniform()) * random_direction(r); }

Mesh loose_triangles(Random& r, int count) {
  Mesh m;
  for (int t = 0; t < count; ++t) {
    const Vec3 center = point_around(r, 2);
    for (int k = 0; k < 3; ++k) m.vertices.push_back(center + point_around(r, 0.3));
    m.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return m;
}

// q is closest to p in a convex set if and only if no point of the set is farther than q towards p.
TEST(MeshDistance, ClosestPointsOfTriangles) {
  Random r(1);
  int found[7] = {};
  for (int k = 0; k < 20000; ++k) {
    const Vec3 corner[3] = {point_around(r, 1), point_around(r, 1), point_around(r, 1)},
               p = point_around(r, 3);
    int feature = -1;
    const Vec3 q = closest_point_on_triangle(p, corner[0], corner[1], corner[2], feature);
    for (const Vec3& x : corner) EXPECT_LT((p - q).dot(x - q), 1e-12);
    ASSERT_GE(feature, 0);
    ASSERT_LT(feature, 7);
    ++found[feature];
    const Vec3 n = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
    EXPECT_NEAR(n.dot(q - corner[0]), 0, 1e-9);
    if (feature < 3) {
      EXPECT_EQ(q, corner[feature]);
    }
    if (feature >= 3 && feature < 6) {
      const Vec3 &a = corner[feature - 3], &b = corner[(feature - 2) % 3];
      EXPECT_NEAR((q - a).norm() + (b - q).norm(), (b - a).norm(), 1e-12);
    }
    EXPECT_NEAR(squared_distance_to_triangle(p, corner[0], corner[1], corner[2]), (p - q).squaredNorm(),
                1e-12);
  }
  for (int n : found) EXPECT_GT(n, 200);
}

TEST(MeshDistance, TheTreeFindsWhatAllTrianglesHave) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Random r(seed);
    const Mesh m = loose_triangles(r, 1 + static_cast<int>(r.below(300)));
    const AabbTree tree(m, 1 + static_cast<int>(seed % 4));
    for (int k = 0; k < 200; ++k) {
      const Vec3 p = point_around(r, 4);
      double least = 1e300;
      for (const auto& t : m.triangles)
        least = std::min(
            least, squared_distance_to_triangle(p, m.vertices[t[0]], m.vertices[t[1]], m.vertices[t[2]]));
      EXPECT_EQ(squared_distance(m, tree, p, 1e300), least);
      EXPECT_EQ(squared_distance(m, tree, p, 1.5 * least), least);
      EXPECT_EQ(squared_distance(m, tree, p, 0.5 * least), 0.5 * least);
    }
  }
  EXPECT_EQ(squared_distance({}, AabbTree({}), Vec3::Zero(), 2), 2);
}

// Every box contains its triangles, and every triangle is in one leaf.
TEST(MeshDistance, BoxesContainTheirTriangles) {
  Random r(4);
  const Mesh m = loose_triangles(r, 500);
  const AabbTree tree(m, 3);
  std::vector<int> leaves(m.triangles.size(), 0);
  for (const auto& node : tree.nodes) {
    EXPECT_LE(node.count, 3);
    for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
      ++leaves[tree.triangles[k]];
      for (const auto v : m.triangles[tree.triangles[k]])
        EXPECT_EQ(node.box.squared_distance(m.vertices[v]), 0);
    }
  }
  for (int n : leaves) EXPECT_EQ(n, 1);
  for (std::size_t k = 0; k < tree.nodes.size(); ++k) {
    if (tree.nodes[k].right == 0) continue;
    for (const std::size_t child : {k + 1, static_cast<std::size_t>(tree.nodes[k].right)}) {
      EXPECT_EQ(tree.nodes[k].box.squared_distance(tree.nodes[child].box.low), 0);
      EXPECT_EQ(tree.nodes[k].box.squared_distance(tree.nodes[child].box.high), 0);
    }
  }
}

}  // namespace
}  // namespace terrazzo
