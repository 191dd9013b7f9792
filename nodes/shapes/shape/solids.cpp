#include "nodes/shapes/shape/solids.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/shape/closed_form.h"

namespace terrazzo::shape {

namespace {

// Scales all vertices by one factor, so that the tessellation has the solid's volume.
void match_volume(Mesh& mesh, double volume) {
  const double s = std::cbrt(volume / mesh_volume(mesh));
  for (auto& v : mesh.vertices) v *= s;
}

// Six n × n grids on the faces of the cube [−1, 1]³ with shared borders.
Mesh cube_grid(int n) {
  Mesh mesh;
  std::map<std::array<int, 3>, int> index;
  auto vertex = [&](std::array<int, 3> at) {
    const auto [it, fresh] = index.try_emplace(at, count_of(mesh.vertices));
    if (fresh) mesh.vertices.push_back(Vec3(at[0], at[1], at[2]) * (2.0 / n) - Vec3::Ones());
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          auto at = [&](int di, int dj) {
            std::array<int, 3> p;
            p[axis] = side * n;
            p[(axis + 1) % 3] = i + di;
            p[(axis + 2) % 3] = j + dj;
            return vertex(p);
          };
          int q[4] = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
          if (side == 0) std::swap(q[1], q[3]);
          // Diagonals that point away from the middle of the face keep the mesh symmetric.
          if ((2 * i < n) == (2 * j < n)) {
            mesh.triangles.push_back({q[0], q[1], q[2]});
            mesh.triangles.push_back({q[0], q[2], q[3]});
          } else {
            mesh.triangles.push_back({q[1], q[2], q[3]});
            mesh.triangles.push_back({q[1], q[3], q[0]});
          }
        }
  return mesh;
}

// The dual of the icosahedron: a vertex for each of its faces, a pentagon (three triangles) for
// each of its vertices.
Mesh dodecahedron() {
  const Mesh ico = icosahedron_mesh();
  Mesh m;
  for (const auto& t : ico.triangles)
    m.vertices.push_back((ico.vertices[t[0]] + ico.vertices[t[1]] + ico.vertices[t[2]]) / 3);
  for (int v = 0; v < 12; ++v) {
    // Neighbor → the next neighbor around v, and the face between.
    std::map<int, std::pair<int, int>> next;
    for (int f = 0; f < 20; ++f)
      for (int k = 0; k < 3; ++k)
        if (ico.triangles[f][k] == v)
          next[ico.triangles[f][(k + 1) % 3]] = {ico.triangles[f][(k + 2) % 3], f};
    std::vector<int> ring;
    for (int at = next.begin()->first; ring.size() < 5; at = next[at].first) ring.push_back(next[at].second);
    for (int k = 1; k < 4; ++k) m.triangles.push_back({ring[0], ring[k], ring[k + 1]});
  }
  const double edge = (m.vertices[m.triangles[0][0]] - m.vertices[m.triangles[0][1]]).norm();
  for (auto& v : m.vertices) v /= edge;
  return m;
}

}  // namespace

Mesh ellipsoid_mesh(const Vec3& extents, int detail) {
  Mesh mesh = geodesic_sphere(detail);
  for (auto& v : mesh.vertices) v = v.cwiseProduct(extents / 2);
  match_volume(mesh, *ellipsoid_closed_form(extents).volume);
  return mesh;
}

Mesh box_mesh(const Vec3& extents) {
  Mesh mesh = cube_grid(1);
  for (auto& v : mesh.vertices) v = v.cwiseProduct(extents / 2);
  return mesh;
}

Mesh cylinder_mesh(const Vec3& extents, int detail) {
  const int n = 8 << detail;
  // The regular n-gon with the area of the circle.
  const double angle = 2 * std::numbers::pi / n, r = std::sqrt(angle / std::sin(angle));
  const Vec3 s = extents / 2;
  Mesh mesh;
  for (const double z : {-s.z(), s.z()})
    for (int i = 0; i < n; ++i)
      mesh.vertices.emplace_back(s.x() * r * std::cos(angle * i), s.y() * r * std::sin(angle * i), z);
  mesh.vertices.emplace_back(0, 0, -s.z());
  mesh.vertices.emplace_back(0, 0, s.z());
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
    mesh.triangles.push_back({2 * n, j, i});
    mesh.triangles.push_back({2 * n + 1, n + i, n + j});
  }
  return mesh;
}

Mesh superquadric_mesh(const Vec3& extents, double e1, double e2, int detail) {
  Mesh mesh = cube_grid(1 << detail);
  for (auto& v : mesh.vertices) {
    // Scale by the largest coordinate first: powers up to 2/0.1 of small numbers would underflow.
    const double xy = std::pow(std::pow(std::abs(v.x()), 2 / e2) + std::pow(std::abs(v.y()), 2 / e2), e2 / 2);
    const double m = std::max(xy, std::abs(v.z()));
    const double f = std::pow(xy / m, 2 / e1) + std::pow(std::abs(v.z()) / m, 2 / e1);
    v = (v / (m * std::pow(f, e1 / 2))).cwiseProduct(extents / 2);
  }
  match_volume(mesh, *superquadric_closed_form(extents, e1, e2).volume);
  return mesh;
}

Mesh platonic_mesh(SolidKind kind) {
  if (kind == SolidKind::Icosahedron) return icosahedron_mesh();
  if (kind == SolidKind::Dodecahedron) return dodecahedron();
  Mesh m;
  if (kind == SolidKind::Tetrahedron) {
    m.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    m.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    for (auto& v : m.vertices) v /= 2 * std::sqrt(2.0);
    return m;
  }
  m.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  m.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (auto& v : m.vertices) v /= std::sqrt(2.0);
  return m;
}

}  // namespace terrazzo::shape
