// Meshes and shapes that tests of several nodes use.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/shapes.h"

namespace terrazzo::test {

// Around the origin.
inline Mesh cube_mesh(double edge = 1) {
  Mesh m;
  for (int i = 0; i < 8; ++i)
    m.vertices.push_back(edge * (Vec3(i & 1, i >> 1 & 1, i >> 2) - Vec3::Constant(0.5)));
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

// Splits each triangle of a mesh on the unit sphere into four, `times` times.
inline Mesh refined_on_sphere(Mesh m, int times) {
  for (int k = 0; k < times; ++k) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [it, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<int>(m.vertices.size()));
      if (fresh) m.vertices.push_back((m.vertices[a] + m.vertices[b]).normalized());
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : m.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    m.triangles = std::move(finer);
  }
  return m;
}

// One shape with the measures of this mesh.
inline Shapes one_shape(Mesh mesh) {
  Shapes s;
  s.shapes.push_back(measure_shape("body", std::move(mesh)));
  return s;
}

}  // namespace terrazzo::test
