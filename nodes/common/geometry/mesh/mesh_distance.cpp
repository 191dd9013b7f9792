#include "nodes/common/geometry/mesh/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace terrazzo {

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
  double side = 1;
  const double square = tree_.visit_near(
      p, bound < 1e150 ? bound * bound * (1 + 1e-9) : 1e300, [&](std::int32_t t, double best) {
        const auto& tri = mesh_.triangles[t];
        int feature;
        const Vec3 q = closest_point_on_triangle(p, mesh_.vertices[tri[0]], mesh_.vertices[tri[1]],
                                                 mesh_.vertices[tri[2]], feature);
        const double d = (p - q).squaredNorm();
        if (d > best || face_normal_[t].isZero()) return best;
        const Vec3& n = feature == 6  ? face_normal_[t]
                        : feature > 2 ? edge_normal_[t][feature - 3]
                                      : vertex_normal_[tri[feature]];
        side = (p - q).dot(n) >= 0 ? 1 : -1;
        return d;
      });
  return side * std::sqrt(square);
}

double squared_distance(const Mesh& mesh, const AabbTree& tree, const Vec3& p, double bound) {
  return tree.visit_near(p, bound, [&](std::int32_t t, double best) {
    const auto& tri = mesh.triangles[t];
    return std::min(best, squared_distance_to_triangle(p, mesh.vertices[tri[0]], mesh.vertices[tri[1]],
                                                       mesh.vertices[tri[2]]));
  });
}

namespace {

// The feature that contains the closest point, and where on it: a + s (b − a), b + s (c − b) or a + s (c − a)
// on an edge, a + s/sum (b − a) + t/sum (c − a) in the interior.
struct OnTriangle {
  int feature;
  double s = 0, t = 0, sum = 1;
};

// Ericson, Real-Time Collision Detection (2005), section 5.1.5: cases by the Voronoi region of p's
// projection.
OnTriangle closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {3, d1 / (d1 - d3)};
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {2};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {5, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {4, (d4 - d3) / ((d4 - d3) + (d5 - d6))};
  return {6, vb, vc, va + vb + vc};
}

}  // namespace

Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int& feature) {
  const OnTriangle at = closest_on_triangle(p, a, b, c);
  feature = at.feature;
  if (feature < 3) return feature == 0 ? a : feature == 1 ? b : c;
  if (feature == 3) return a + at.s * (b - a);
  if (feature == 4) return b + at.s * (c - b);
  if (feature == 5) return a + at.s * (c - a);
  const double k = 1 / at.sum;
  return a + at.s * k * (b - a) + at.t * k * (c - a);
}

double squared_distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const OnTriangle at = closest_on_triangle(p, a, b, c);
  const Vec3 ap = p - a, bp = p - b, cp = p - c;
  switch (at.feature) {
    case 0:
      return ap.squaredNorm();
    case 1:
      return bp.squaredNorm();
    case 2:
      return cp.squaredNorm();
    case 3:
      return (ap - at.s * (b - a)).squaredNorm();
    case 4:
      return (bp - at.s * (c - b)).squaredNorm();
    case 5:
      return (ap - at.s * (c - a)).squaredNorm();
  }
  if (at.sum <= 0) return std::min({ap.squaredNorm(), bp.squaredNorm(), cp.squaredNorm()});  // degenerate
  return (ap - at.s / at.sum * (b - a) - at.t / at.sum * (c - a)).squaredNorm();
}

}  // namespace terrazzo
