// Meshes and particles with closed-form measures, for voxelization tests.
#pragma once

#include <cmath>
#include <numbers>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/random.h"
#include "tests/support/meshes.h"

namespace terrazzo::test {

// A sphere of diameter 1, scaled so that the mesh has the exact volume of the sphere.
inline Mesh sphere_mesh(int level) {
  Mesh m;
  const double t = (1 + std::sqrt(5.0)) / 2;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-t, t})
      m.vertices.push_back({a, b, 0}), m.vertices.push_back({0, a, b}), m.vertices.push_back({b, 0, a});
  // Faces are all triples of vertices at mutual distance 2, oriented outward.
  const int n = static_cast<int>(m.vertices.size());
  const auto near = [&](int a, int b) { return std::abs((m.vertices[a] - m.vertices[b]).norm() - 2) < 1e-9; };
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      for (int c = b + 1; c < n; ++c)
        if (near(a, b) && near(b, c) && near(a, c)) {
          const Vec3 normal = (m.vertices[b] - m.vertices[a]).cross(m.vertices[c] - m.vertices[a]);
          m.triangles.push_back(normal.dot(m.vertices[a]) > 0 ? Triangle{a, b, c} : Triangle{a, c, b});
        }
  for (auto& v : m.vertices) v.normalize();
  m = refined_on_sphere(std::move(m), level);
  double volume = 0;
  for (const auto& [a, b, c] : m.triangles)
    volume += m.vertices[a].dot(m.vertices[b].cross(m.vertices[c])) / 6;
  const double factor = std::cbrt(std::numbers::pi / 6 / volume);
  for (auto& v : m.vertices) v *= factor;
  return m;
}

inline Shapes shapes_of(Mesh mesh) {
  Shapes s;
  s.shapes.resize(1);
  s.shapes[0].name = "body";
  s.shapes[0].mesh = std::move(mesh);
  return s;
}

inline Quat random_turn(Random& r) {
  return Quat(r.normal(), r.normal(), r.normal(), r.normal()).normalized();
}

inline Particles one_particle(Vec3 box, Vec3 position, double scale) {
  Particles p;
  p.box = box;
  p.resize(1);
  p.position[0] = position;
  p.scale[0] = p.size[0] = scale;
  p.color[0] = Vec3f(0.8f, 0.2f, 0.1f);
  p.binder_color = Vec3f(0.1f, 0.3f, 0.5f);
  return p;
}

}  // namespace terrazzo::test
