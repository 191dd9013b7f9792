// Exact signed distance from a point to a closed triangle mesh.
#pragma once

#include <vector>

#include "nodes/packing/aabb_tree.h"

namespace terrazzo::packing {

class MeshDistance {
 public:
  explicit MeshDistance(const Mesh& mesh);  // keeps a reference
  // Negative inside, mm. `bound` is a known upper bound of the unsigned distance, or infinity. The sign comes
  // from angle-weighted pseudonormals (Bærentzen and Aanæs 2005).
  double signed_distance(const Vec3& p, double bound = 1e300) const;

 private:
  const Mesh& mesh_;
  AabbTree tree_;
  std::vector<Vec3> face_normal_, vertex_normal_;
  std::vector<std::array<Vec3, 3>> edge_normal_;  // of triangle t, edge k from corner k to k + 1
};

// The point of triangle abc closest to p. `feature`: 0–2 corner, 3–5 edge (corner k to k + 1), 6 interior.
Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int& feature);

}  // namespace terrazzo::packing
