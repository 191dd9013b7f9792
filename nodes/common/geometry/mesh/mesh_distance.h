// Exact distances from a point to triangles.
#pragma once

#include <vector>

#include "nodes/common/geometry/mesh/aabb_tree.h"

namespace terrazzo {

// Of a closed mesh.
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

// Squared distance from p to a mesh, of which `tree` is the tree, if it is below `bound`, else `bound`. mm².
double squared_distance(const Mesh&, const AabbTree& tree, const Vec3& p, double bound);

// The point of triangle abc closest to p. `feature`: 0–2 corner, 3–5 edge (corner k to k + 1), 6 interior.
Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int& feature);

// Squared distance from p to triangle abc. With less rounding than from the closest point.
double squared_distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace terrazzo
