// A mesh with its normals in single precision, for ray tracing.
#pragma once

#include <vector>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/common/geometry/mesh/render_mesh.h"

namespace terrazzo::carving {

struct RayMesh {
  RayScene::Triangles triangles;
  std::vector<Vec3f> normals;

  explicit RayMesh(const Shape& shape) {
    const RenderMesh m = render_mesh(shape);
    for (const Vec3& p : m.positions) triangles.positions.push_back(p.cast<float>());
    for (const Vec3& n : m.normals) normals.push_back(n.cast<float>());
    triangles.indices = m.indices;
  }
  void normals_at(const RayHit& hit, Vec3f& face, Vec3f& normal) const {
    const std::uint32_t* i = &triangles.indices[3 * static_cast<std::size_t>(hit.triangle)];
    const auto& p = triangles.positions;
    face = (p[i[1]] - p[i[0]]).cross(p[i[2]] - p[i[0]]).normalized();
    normal =
        (normals[i[0]] * (1 - hit.u - hit.v) + normals[i[1]] * hit.u + normals[i[2]] * hit.v).normalized();
  }
};

}  // namespace terrazzo::carving
