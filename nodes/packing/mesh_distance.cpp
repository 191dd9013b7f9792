#include "nodes/packing/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace terrazzo::packing {

MeshDistance::MeshDistance(const Mesh& mesh)
    : mesh_(mesh),
      tree_(mesh),
      face_normal_(mesh.triangles.size(), Vec3::Zero()),
      vertex_normal_(mesh.vertices.size(), Vec3::Zero()),
      edge_normal_(mesh.triangles.size()) {
  std::map<std::pair<int, int>, Vec3> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    const Vec3 &a = mesh.vertices[tri[0]], &b = mesh.vertices[tri[1]], &c = mesh.vertices[tri[2]];
    const Vec3 n = (b - a).cross(c - a);
    if (n.squaredNorm() > 0) face_normal_[t] = n.normalized();
    for (int k = 0; k < 3; ++k) {
      const Vec3 u = mesh.vertices[tri[(k + 1) % 3]] - mesh.vertices[tri[k]];
      const Vec3 v = mesh.vertices[tri[(k + 2) % 3]] - mesh.vertices[tri[k]];
      vertex_normal_[tri[k]] += std::atan2(u.cross(v).norm(), u.dot(v)) * face_normal_[t];
      const auto key = std::minmax(tri[k], tri[(k + 1) % 3]);
      edges.emplace(std::pair<int, int>(key), Vec3::Zero()).first->second += face_normal_[t];
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto key = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      edge_normal_[t][k] = edges.at(std::pair<int, int>(key));
    }
}

double MeshDistance::signed_distance(const Vec3& p, double bound) const {
  double best = bound < 1e150 ? bound * bound * (1 + 1e-9) : 1e300;
  double side = 1;
  std::int32_t stack[64];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const std::int32_t k = stack[--top];
    const auto& node = tree_.nodes[k];
    if (node.box.squared_distance(p) > best) continue;
    if (node.right == 0) {
      for (int m = node.first; m < node.first + node.count; ++m) {
        const std::int32_t t = tree_.triangles[m];
        const auto& tri = mesh_.triangles[t];
        int feature;
        const Vec3 q = closest_point_on_triangle(p, mesh_.vertices[tri[0]], mesh_.vertices[tri[1]],
                                                 mesh_.vertices[tri[2]], feature);
        const double d = (p - q).squaredNorm();
        if (d > best || face_normal_[t].isZero()) continue;
        best = d;
        const Vec3& n = feature == 6  ? face_normal_[t]
                        : feature > 2 ? edge_normal_[t][feature - 3]
                                      : vertex_normal_[tri[feature]];
        side = (p - q).dot(n) >= 0 ? 1 : -1;
      }
      continue;
    }
    const double left = tree_.nodes[k + 1].box.squared_distance(p);
    const double right = tree_.nodes[node.right].box.squared_distance(p);
    const bool left_first = left <= right;
    stack[top++] = left_first ? node.right : k + 1;
    stack[top++] = left_first ? k + 1 : node.right;
  }
  return side * std::sqrt(best);
}

Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int& feature) {
  // Voronoi regions of the triangle's features (Ericson 2005, section 5.1.5).
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return feature = 0, a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return feature = 1, b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return feature = 3, a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return feature = 2, c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return feature = 5, a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return feature = 4, b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  feature = 6;
  const double s = 1 / (va + vb + vc);
  return a + vb * s * ab + vc * s * ac;
}

}  // namespace terrazzo::packing
