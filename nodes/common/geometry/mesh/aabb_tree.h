// A bounding volume hierarchy (BVH) of axis-aligned boxes over triangles, for closest
// points, rays and intersections.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

struct Aabb {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void add(const Aabb& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
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

  // Visits the triangles whose boxes are at most √bound from p, with nearer boxes first. `visit(triangle,
  // bound)` returns the new, smaller or equal bound. Returns the last one.
  template <class Visit>
  double visit_near(const Vec3& p, double bound, Visit&& visit) const {
    struct Open {
      std::int32_t node;
      double distance;  // squared, of its box
    } stack[64];        // of halves, so deep enough for any mesh
    int top = 0;
    if (!nodes.empty()) stack[top++] = {0, nodes[0].box.squared_distance(p)};
    while (top > 0) {
      const Open open = stack[--top];
      if (open.distance > bound) continue;
      const Node& node = nodes[open.node];
      if (node.right == 0) {
        for (std::int32_t m = node.first; m < node.first + node.count; ++m)
          bound = visit(triangles[m], bound);
        continue;
      }
      // The nearer child is pushed last, so that it is visited first and lowers the bound.
      const Open left{open.node + 1, nodes[open.node + 1].box.squared_distance(p)},
          right{node.right, nodes[node.right].box.squared_distance(p)};
      const bool left_first = left.distance <= right.distance;
      const Open &nearer = left_first ? left : right, &farther = left_first ? right : left;
      if (farther.distance <= bound) stack[top++] = farther;
      if (nearer.distance <= bound) stack[top++] = nearer;
    }
    return bound;
  }

  std::vector<Node> nodes;              // at least one if the mesh has triangles
  std::vector<std::int32_t> triangles;  // triangle indices, leaves as consecutive ranges

 private:
  void split(const std::vector<Aabb>& boxes, int first, int count, int leaf_size);
};

}  // namespace terrazzo
