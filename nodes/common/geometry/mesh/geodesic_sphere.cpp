#include "nodes/common/geometry/mesh/geodesic_sphere.h"

#include <algorithm>
#include <map>
#include <numbers>

#include "nodes/data/indices.h"

namespace terrazzo {

namespace {

// Splits each triangle into four; adjacent triangles share midpoints.
void split_in_four(Mesh& mesh) {
  std::map<std::pair<int, int>, int> midpoint;
  auto middle = [&](int a, int b) {
    const auto [it, fresh] = midpoint.try_emplace(std::minmax(a, b), count_of(mesh.vertices));
    if (fresh) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]) / 2);
    return it->second;
  };
  std::vector<Triangle> out;
  out.reserve(mesh.triangles.size() * 4);
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    out.push_back({a, ab, ca});
    out.push_back({b, bc, ab});
    out.push_back({c, ca, bc});
    out.push_back({ab, bc, ca});
  }
  mesh.triangles = std::move(out);
}

}  // namespace

Mesh icosahedron_mesh() {
  const double p = std::numbers::phi;
  Mesh m;
  m.vertices = {{-1, p, 0},  {1, p, 0},  {-1, -p, 0}, {1, -p, 0}, {0, -1, p},  {0, 1, p},
                {0, -1, -p}, {0, 1, -p}, {p, 0, -1},  {p, 0, 1},  {-p, 0, -1}, {-p, 0, 1}};
  m.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (auto& v : m.vertices) v /= 2;  // scales edge length 2 to 1
  return m;
}

Mesh geodesic_sphere(int detail) {
  Mesh mesh = icosahedron_mesh();
  for (int i = 0; i < detail; ++i) {
    split_in_four(mesh);
    for (auto& v : mesh.vertices) v.normalize();
  }
  for (auto& v : mesh.vertices) v.normalize();
  return mesh;
}

}  // namespace terrazzo
