// Exact plane sections of closed meshes.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/data/shapes.h"

namespace terrazzo {

// The section of `mesh` by the plane {x : u·x = h} in the coordinates (a·x, b·x), where a, b, u are the
// columns of a rotation. Vertices on the plane count as above it, so that every section is a set of closed
// loops. Empty if the plane misses the mesh.
std::vector<Loop> section_loops(const Mesh& mesh, const Mat3& a_b_u, double h);

// Cuts one mesh by many planes: skips clusters of neighboring triangles that the plane misses. The mesh must
// outlive the cutter, which only one thread may use.
class MeshCutter {
 public:
  explicit MeshCutter(const Mesh&);
  // Smallest and largest u·x over the vertices.
  std::pair<double, double> turn(const Vec3& u);
  // The loops of section_loops, to the bit. Faster after turn(u).
  std::vector<Loop> loops(const Mat3& a_b_u, double h);

 private:
  static constexpr std::size_t kCluster = 16;
  struct Cluster {
    Vec3 center;
    double radius;
    std::size_t first, last;  // triangles
  };
  const Mesh& mesh_;
  std::vector<Cluster> clusters_;
  Vec3 u_ = Vec3::Zero();                  // direction of along_
  std::vector<double> x_, y_, z_, along_;  // per vertex
  std::vector<std::pair<std::size_t, std::size_t>> ranges_;
};

// Groups loops into disjoint profiles: each has an outer loop first, then its holes. Loops without area are
// dropped, and so are holes outside every outer loop, which occur only in self-intersecting surfaces.
std::vector<std::vector<Loop>> section_profiles(std::vector<Loop> loops);

}  // namespace terrazzo
