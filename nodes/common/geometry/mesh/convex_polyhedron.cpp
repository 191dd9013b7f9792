#include "nodes/common/geometry/mesh/convex_polyhedron.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/data/indices.h"

namespace terrazzo {

double ConvexPolyhedron::shortest_edge() const {
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& f : faces)
    for (std::size_t i = 0; i < f.size(); ++i)
      shortest = std::min(shortest, (corners[f[i]] - corners[f[(i + 1) % f.size()]]).norm());
  return std::isfinite(shortest) ? shortest : 0;
}

ConvexPolyhedron intersect(const std::vector<HalfSpace>& planes) {
  ConvexPolyhedron p;
  p.faces.resize(planes.size());
  const std::size_t n = planes.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        Mat3 m;
        m << planes[i].normal.transpose(), planes[j].normal.transpose(), planes[k].normal.transpose();
        if (std::abs(m.determinant()) < 1e-9) continue;
        const Vec3 x = m.inverse() * Vec3(planes[i].offset, planes[j].offset, planes[k].offset);
        bool inside = x.allFinite();
        for (std::size_t l = 0; inside && l < n; ++l)
          inside = l == i || l == j || l == k || planes[l].normal.dot(x) <= planes[l].offset;
        if (!inside) continue;
        for (const auto f : {i, j, k}) p.faces[f].push_back(count_of(p.corners));
        p.corners.push_back(x);
      }
  for (std::size_t f = 0; f < n; ++f) {
    auto& face = p.faces[f];
    Vec3 middle = Vec3::Zero();
    for (const int c : face) middle += p.corners[c] / static_cast<double>(face.size());
    const Vec3 a = planes[f].normal.unitOrthogonal(), b = planes[f].normal.cross(a);
    const auto angle = [&](int c) {
      const Vec3 d = p.corners[c] - middle;
      return std::atan2(b.dot(d), a.dot(d));
    };
    std::sort(face.begin(), face.end(), [&](int x, int y) { return angle(x) < angle(y); });
  }
  return p;
}

Mesh triangulate(const ConvexPolyhedron& p) {
  Mesh mesh;
  mesh.vertices = p.corners;
  for (const auto& f : p.faces) {
    if (f.empty()) continue;
    Vec3 middle = Vec3::Zero();
    for (const int c : f) middle += p.corners[c] / static_cast<double>(f.size());
    const int m = mesh.vertices.size();
    mesh.vertices.push_back(middle);
    for (std::size_t i = 0; i < f.size(); ++i) mesh.triangles.push_back({m, f[i], f[(i + 1) % f.size()]});
  }
  return mesh;
}

}  // namespace terrazzo
