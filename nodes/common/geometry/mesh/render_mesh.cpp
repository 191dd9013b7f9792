#include "nodes/common/geometry/mesh/render_mesh.h"

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

// The angle between two edges at a corner.
double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

RenderMesh render_mesh(const Shape& shape) {
  const Mesh& mesh = shape.mesh;
  const std::int64_t n = mesh.vertices.size();
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!mesh.vertices[v].allFinite())
      throw Error("bad-number",
                  "vertex " + std::to_string(v) + " of shape '" + shape.name + "' is not finite");

  RenderMesh out;
  if (shape.smooth) {
    out.positions = mesh.vertices;
    out.normals.assign(mesh.vertices.size(), Vec3::Zero());
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) out.vertex.push_back(v);
  }
  for (std::size_t at = 0; at < mesh.triangles.size(); ++at) {
    const Triangle& t = mesh.triangles[at];
    for (const auto i : t)
      if (i < 0 || i >= n)
        throw Error("bad-mesh", "a triangle of shape '" + shape.name + "' refers to vertex " +
                                    std::to_string(i) + " of " + std::to_string(n));
    const Vec3 p[3] = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    const Vec3 cross = (p[1] - p[0]).cross(p[2] - p[0]);
    if (!(cross.squaredNorm() > 0)) continue;
    const Vec3 normal = cross.normalized();
    out.triangle.push_back(static_cast<std::uint32_t>(at));
    for (int k = 0; k < 3; ++k) {
      if (shape.smooth) {
        out.normals[t[k]] += normal * angle(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        out.indices.push_back(static_cast<std::uint32_t>(t[k]));
      } else {
        out.indices.push_back(static_cast<std::uint32_t>(out.positions.size()));
        out.positions.push_back(p[k]);
        out.vertex.push_back(static_cast<std::uint32_t>(t[k]));
        out.normals.push_back(normal);
      }
    }
  }
  if (out.indices.empty()) throw Error("bad-mesh", "shape '" + shape.name + "' has no triangle with an area");
  // A vertex without triangles, or whose normals cancel, may have any unit normal: use the direction from the
  // origin.
  for (std::size_t v = 0; v < out.normals.size(); ++v) {
    Vec3& normal = out.normals[v];
    if (normal.norm() < 1e-12) normal = out.positions[v];
    normal = normal.norm() > 0 ? normal.normalized() : Vec3::UnitZ();
  }
  return out;
}

}  // namespace terrazzo
