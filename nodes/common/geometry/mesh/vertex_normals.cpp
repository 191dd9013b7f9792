#include "nodes/common/geometry/mesh/vertex_normals.h"

namespace terrazzo {

std::vector<Vec3> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3> out(mesh.vertices.size(), Vec3::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vec3 n =
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    for (const int v : t) out[v] += n;
  }
  for (Vec3& n : out)
    if (n.norm() > 0) n.normalize();
  return out;
}

}  // namespace terrazzo
