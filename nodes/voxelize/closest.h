// Squared distance to a set of triangles.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::voxelize {

double distance2_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

// A bounding volume hierarchy (BVH) over a mesh. The mesh must outlive it.
class ClosestTriangle {
 public:
  explicit ClosestTriangle(const Mesh& mesh);
  // Squared distance from p to the mesh if it is below `bound`, else `bound`.
  double distance2(const Vec3& p, double bound) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::int32_t begin, end;  // triangles of a leaf
    std::int32_t right;       // second child (the first child is the next node); 0 for a leaf
  };
  void build(std::int32_t begin, std::int32_t end, const std::vector<Vec3>& centers);

  const Mesh& mesh_;
  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;
};

}  // namespace terrazzo::voxelize
