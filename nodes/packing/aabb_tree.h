// A bounding volume hierarchy (BVH) of axis-aligned boxes over triangles, for closest
// points, rays and intersections.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::packing {

struct Aabb {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  void add(const Aabb& b) { low = low.cwiseMin(b.low), high = high.cwiseMax(b.high); }
  Vec3 center() const { return 0.5 * (low + high); }
  // 0 inside the box.
  double squared_distance(const Vec3& p) const {
    return (low - p).cwiseMax(p - high).cwiseMax(Vec3::Zero()).squaredNorm();
  }
};

// Nodes in depth-first order: the left child of node k is k + 1.
class AabbTree {
 public:
  struct Node {
    Aabb box;
    std::int32_t right = 0;             // index of the right child; 0 in a leaf
    std::int32_t first = 0, count = 0;  // range of `triangles` in a leaf
  };
  explicit AabbTree(const Mesh& mesh, int leaf_size = 4);
  std::vector<Node> nodes;              // at least one if the mesh has triangles
  std::vector<std::int32_t> triangles;  // triangle indices, leaves as consecutive ranges

 private:
  void split(const std::vector<Aabb>& boxes, int first, int count, int leaf_size);
};

}  // namespace terrazzo::packing
