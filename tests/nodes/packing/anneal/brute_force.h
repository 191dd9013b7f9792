// Test shapes, and an overlap check that shares no code with the node: segments through triangles and the
// parity of a ray, for all pairs and images.
#pragma once

#include <cmath>
#include <functional>
#include <map>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "tests/support/meshes.h"

namespace terrazzo::test {

inline Mesh icosphere(int levels) {
  Mesh m;
  const double t = (1 + std::sqrt(5.0)) / 2;
  m.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  m.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (auto& v : m.vertices) v.normalize();
  return refined_on_sphere(std::move(m), levels);
}

inline Mesh warped(Mesh m, const std::function<Vec3(const Vec3&)>& f) {
  for (auto& v : m.vertices) v = f(v);
  return m;
}

// A union of unit cubes at integer positions, made of the faces that are not shared.
inline Mesh cubes(const std::vector<Vec3i>& places) {
  Mesh m;
  std::map<std::array<int, 3>, int> index;
  const auto vertex = [&](const Vec3i& p) {
    const auto [it, fresh] = index.try_emplace({p[0], p[1], p[2]}, static_cast<int>(m.vertices.size()));
    if (fresh) m.vertices.push_back(p.cast<double>());
    return it->second;
  };
  for (const auto& p : places)
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side) {
        Vec3i next = p;
        next[axis] += side ? 1 : -1;
        bool shared = false;
        for (const auto& q : places) shared = shared || q == next;
        if (shared) continue;
        Vec3i u = Vec3i::Zero(), v = Vec3i::Zero(), o = p;
        u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1, o[axis] += side;
        if (!side) std::swap(u, v);
        const int a = vertex(o), b = vertex(o + u), c = vertex(o + u + v), d = vertex(o + v);
        m.triangles.push_back({a, b, c});
        m.triangles.push_back({a, c, d});
      }
  return m;
}

inline Mesh cube() { return cubes({Vec3i(0, 0, 0)}); }
inline Mesh angle() { return cubes({Vec3i(0, 0, 0), Vec3i(1, 0, 0), Vec3i(0, 1, 0)}); }
inline Mesh tetrahedron() {
  return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}
inline Mesh ellipsoid(int levels) {
  return warped(icosphere(levels), [](const Vec3& v) { return Vec3(1.25 * v[0], v[1], 0.8 * v[2]); });
}
inline Mesh peanut(int levels) {
  return warped(icosphere(levels), [](const Vec3& v) { return Vec3(v * (0.55 + 0.6 * v[0] * v[0])); });
}

inline Shapes shapes_of(std::vector<Mesh> meshes) {
  Shapes s;
  for (auto& m : meshes)
    s.shapes.push_back(measure_shape("shape " + std::to_string(s.shapes.size()), std::move(m),
                                     1.0 / static_cast<double>(meshes.size())));
  return s;
}

// Sizes between low and high with the volume fraction `fraction`, for any of the shapes.
inline SizeDistribution distribution(const Shapes& shapes, double low, double high, double fraction,
                                     int classes = 4) {
  SizeDistribution d;
  for (int k = 0; k <= classes; ++k) d.class_edges.push_back(low + (high - low) * k / classes);
  double unit = 0, cube = 0;
  for (const auto& s : shapes.shapes) unit += s.probability * s.volume / std::pow(s.size(), 3);
  for (int k = 0; k < classes; ++k) {
    const double a = d.class_edges[k], b = d.class_edges[k + 1];
    cube += (a * a + b * b) * (a + b) / 4 / classes;
  }
  SizeDistribution::Entry e;
  e.shape = -1;
  e.N_V.assign(classes, fraction / (unit * cube) / classes);
  e.low = e.high = e.N_V;
  d.shapes.push_back(e);
  d.volume_fraction = fraction;
  d.d_max = high;
  return d;
}

namespace brute {

inline bool segment_hits(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 d = q - p, e = b - a, f = c - a, h = d.cross(f);
  const double det = e.dot(h);
  if (std::abs(det) < 1e-14) return false;
  const Vec3 s = p - a, k = s.cross(e);
  const double u = s.dot(h) / det, v = d.dot(k) / det, t = f.dot(k) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && t >= 0 && t <= 1;
}

inline bool meshes_overlap(const std::vector<Vec3>& p, const std::vector<Triangle>& tp,
                           const std::vector<Vec3>& q, const std::vector<Triangle>& tq) {
  Vec3 lo_p = p[0], hi_p = p[0], lo_q = q[0], hi_q = q[0];
  for (const auto& v : p) {
    lo_p = lo_p.cwiseMin(v);
    hi_p = hi_p.cwiseMax(v);
  }
  for (const auto& v : q) {
    lo_q = lo_q.cwiseMin(v);
    hi_q = hi_q.cwiseMax(v);
  }
  const Vec3 lo = lo_p.cwiseMax(lo_q), hi = hi_p.cwiseMin(hi_q);
  if (!((lo.array() <= hi.array()).all())) return false;
  const auto crossed = [&](const std::vector<Vec3>& x, const std::vector<Triangle>& tx,
                           const std::vector<Vec3>& y, const std::vector<Triangle>& ty) {
    std::vector<const Triangle*> near;
    for (const auto& b : ty) {
      const Vec3 l = y[b[0]].cwiseMin(y[b[1]]).cwiseMin(y[b[2]]),
                 h = y[b[0]].cwiseMax(y[b[1]]).cwiseMax(y[b[2]]);
      if ((l.array() <= hi.array()).all() && (h.array() >= lo.array()).all()) near.push_back(&b);
    }
    for (const auto& a : tx)
      for (int k = 0; k < 3; ++k) {
        const Vec3 &s = x[a[k]], &e = x[a[(k + 1) % 3]];
        if (!((s.cwiseMin(e).array() <= hi.array()).all() && (s.cwiseMax(e).array() >= lo.array()).all()))
          continue;
        for (const Triangle* b : near)
          if (segment_hits(s, e, y[(*b)[0]], y[(*b)[1]], y[(*b)[2]])) return true;
      }
    return false;
  };
  if (crossed(p, tp, q, tq) || crossed(q, tq, p, tp)) return true;
  const auto inside = [](const Vec3& x, const std::vector<Vec3>& y, const std::vector<Triangle>& ty) {
    int hits = 0;
    for (const auto& b : ty)
      hits += segment_hits(x, x + 1e3 * Vec3(.531, .283, .799), y[b[0]], y[b[1]], y[b[2]]);
    return hits % 2 == 1;
  };
  return inside(p[0], q, tq) || inside(q[0], p, tp);
}

// Number of overlapping pairs, after laying `tiles` copies of the box along each axis.
inline int overlaps(const Shapes& shapes, const Particles& particles, int tiles = 1) {
  struct Placed {
    std::vector<Vec3> v;
    const std::vector<Triangle>* t;
    Vec3 center;
    double radius;
  };
  std::vector<Placed> all;
  for (int z = 0; z < tiles; ++z)
    for (int y = 0; y < tiles; ++y)
      for (int x = 0; x < tiles; ++x)
        for (std::size_t i = 0; i < particles.count(); ++i) {
          const Mesh& mesh = shapes.shapes[particles.shape[i]].mesh;
          Placed p{mesh.vertices, &mesh.triangles,
                   particles.position[i] + Vec3(x, y, z).cwiseProduct(particles.box), 0};
          for (auto& v : p.v) {
            v = particles.orientation[i] * (particles.scale[i] * v) + p.center;
            p.radius = std::max(p.radius, (v - p.center).norm());
          }
          all.push_back(std::move(p));
        }
  const Vec3 period = particles.box * tiles;
  int found = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = i; j < all.size(); ++j)
      for (int image = 0; image < 27; ++image) {
        const Vec3i n(image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1);
        if (i == j && n.isZero()) continue;
        const Vec3 shift = n.cast<double>().cwiseProduct(period);
        if ((all[j].center + shift - all[i].center).norm() >= all[i].radius + all[j].radius) continue;
        auto moved = all[j].v;
        for (auto& v : moved) v += shift;
        found += meshes_overlap(all[i].v, *all[i].t, moved, *all[j].t);
      }
  return found;
}

}  // namespace brute
}  // namespace terrazzo::test
