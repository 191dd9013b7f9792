// Small shapes and random particle sets with known measures.
#pragma once

#include <cmath>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/particles.h"
#include "runtime/random.h"

namespace terrazzo::test {

inline Mesh box_mesh(double a, double b, double c, const Vec3& corner) {
  Mesh m;
  for (int i = 0; i < 8; ++i)
    m.vertices.push_back(corner + Vec3(i & 1 ? a : 0, i & 2 ? b : 0, i & 4 ? c : 0));
  m.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return m;
}
inline Shape cube(double edge = 1) {
  return measure_shape("cube", box_mesh(edge, edge, edge, Vec3::Constant(-edge / 2)));
}

// A ring with a square outline, whose sections have one region, two regions, or one region with a hole.
inline Shape square_ring() {
  Mesh m;
  const double outer = 1, inner = 0.5, half = 0.25;
  for (double z : {-half, half})
    for (double r : {outer, inner})
      for (int k = 0; k < 4; ++k) m.vertices.emplace_back(k == 0 || k == 3 ? r : -r, k < 2 ? r : -r, z);
  auto quad = [&](int a, int b, int c, int d) {
    m.triangles.push_back({a, b, c});
    m.triangles.push_back({a, c, d});
  };
  for (int k = 0; k < 4; ++k) {
    const int n = (k + 1) % 4;
    quad(k, n, 8 + n, 8 + k);            // outer wall
    quad(4 + n, 4 + k, 12 + k, 12 + n);  // inner wall
    quad(8 + k, 8 + n, 12 + n, 12 + k);  // top
    quad(n, k, 4 + k, 4 + n);            // bottom
  }
  return measure_shape("ring", m);
}

inline Particles random_particles(std::uint64_t seed, int n, double box, double lo, double hi,
                                  int shapes = 1) {
  Particles p;
  p.box = Vec3::Constant(box);
  p.resize(n);
  for (int i = 0; i < n; ++i) {
    Random r(seed, 5, i);
    for (int k = 0; k < 3; ++k) p.position[i][k] = r.uniform(0, box);
    p.orientation[i] = Quat(r.normal(), r.normal(), r.normal(), r.normal()).normalized();
    p.scale[i] = r.uniform(lo, hi);
    p.shape[i] = static_cast<int>(r.below(shapes));
    p.cls[i] = i % 2;
    p.color[i] = Vec3f(r.uniform(.2, .9), r.uniform(.2, .8), r.uniform(.1, .7));
  }
  p.binder_color = Vec3f(0.02f, 0.02f, 0.03f);
  return p;
}

// The same without overlapping bounding spheres, by random sequential addition.
inline Particles apart_particles(std::uint64_t seed, int n, double box, double lo, double hi,
                                 const Shape& shape) {
  Particles p = random_particles(seed, n, box, lo, hi);
  double radius = 0;
  for (const Vec3& v : shape.mesh.vertices) radius = std::max(radius, v.norm());
  std::vector<int> kept;
  for (int i = 0; i < n; ++i) {
    bool free = true;
    for (int j : kept) {
      Vec3 d = p.position[i] - p.position[j];
      for (int k = 0; k < 3; ++k) d[k] -= box * std::round(d[k] / box);
      free = free && d.norm() > radius * (p.scale[i] + p.scale[j]);
    }
    if (free) kept.push_back(i);
  }
  Particles q = p;
  q.resize(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const int k = kept[i];
    q.position[i] = p.position[k];
    q.orientation[i] = p.orientation[k];
    q.scale[i] = p.scale[k];
    q.color[i] = p.color[k];
    q.cls[i] = p.cls[k];
  }
  return q;
}

}  // namespace terrazzo::test
