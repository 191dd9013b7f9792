// Signed distance near a mesh, sampled once on a lattice and shared by all instances of similar size.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/volumes/voxelize/scan.h"
#include "runtime/work.h"

namespace terrazzo::voxelize {

class MeshSdf {
 public:
  // Uses `cells` lattice cells along the mesh's longest extent. Distances up to `band` cells are exact at the
  // nodes (closest point on the triangles, sign by winding number) and interpolated linearly between them.
  // Larger distances are clamped to ±band.
  MeshSdf(const Mesh& mesh, int cells, double band, const Work& work);

  // Signed distance, negative inside, in the mesh's unit.
  float at(const Vec3& p) const;

 private:
  CellBox box_;
  Vec3 origin_;  // of node (0, 0, 0)
  double spacing_;
  float far_;  // band in the mesh's unit
  std::vector<float> nodes_;
};

}  // namespace terrazzo::voxelize
