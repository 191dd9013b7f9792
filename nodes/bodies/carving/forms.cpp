#include "nodes/bodies/carving/forms.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo::carving {
namespace {

void quad(Mesh& m, int a, int b, int c, int d) {
  m.triangles.push_back({a, b, c});
  m.triangles.push_back({a, c, d});
}

// Moves the mesh onto the floor, centered on the z axis, and scales its longest edge to 1.
Shape finished(const char* name, Mesh mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  const double scale = 1 / box.sizes().maxCoeff();
  const Vec3 foot(box.center().x(), box.center().y(), box.min().z());
  for (Vec3& v : mesh.vertices) v = (v - foot) * scale;
  Shape s;
  s.name = name;
  s.smooth = true;
  s.mesh = std::move(mesh);
  return s;
}

// Points of a Catmull–Rom spline through `knots`, with `steps` per span.
std::vector<Vec2> smoothed(const std::vector<Vec2>& knots, int steps) {
  std::vector<Vec2> out;
  const auto at = [&](int i) { return knots[std::clamp(i, 0, count_of(knots) - 1)]; };
  for (int i = 0; i + 1 < count_of(knots); ++i)
    for (int s = 0; s < steps; ++s) {
      const double t = double(s) / steps;
      const Vec2 a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
      out.push_back(0.5 * (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) +
                           t * t * t * (3 * b - a - 3 * c + d)));
    }
  out.push_back(knots.back());
  return out;
}

}  // namespace

Shape vase_form() {
  // Radius and height: up the outside, over the lip, down the inside.
  const std::vector<Vec2> profile =
      smoothed({{0.20, 0.000},  {0.235, 0.012}, {0.25, 0.05}, {0.31, 0.17},   {0.36, 0.33},   {0.355, 0.50},
                {0.28, 0.67},   {0.19, 0.80},   {0.17, 0.88}, {0.205, 0.965}, {0.225, 0.995}, {0.21, 1.0},
                {0.185, 0.975}, {0.145, 0.88},  {0.16, 0.79}, {0.25, 0.66},   {0.32, 0.50},   {0.325, 0.33},
                {0.28, 0.18},   {0.20, 0.08},   {0.10, 0.05}},
               6);
  constexpr int kTurns = 120;
  Mesh m;
  m.vertices.push_back(Vec3(0, 0, 0));
  for (const Vec2& p : profile)
    for (int j = 0; j < kTurns; ++j) {
      const double a = 2 * M_PI * j / kTurns;
      m.vertices.push_back(Vec3(p.x() * std::cos(a), p.x() * std::sin(a), p.y()));
    }
  const int last = m.vertices.size();
  m.vertices.push_back(Vec3(0, 0, 0.047));
  const int rings = profile.size();
  for (int j = 0; j < kTurns; ++j) {
    const int k = (j + 1) % kTurns;
    m.triangles.push_back({0, 1 + k, 1 + j});
    for (int i = 0; i + 1 < rings; ++i) {
      const int a = 1 + i * kTurns;
      quad(m, a + j, a + k, a + kTurns + k, a + kTurns + j);
    }
    m.triangles.push_back({last - kTurns + j, last - kTurns + k, last});
  }
  return finished("vase", std::move(m));
}

Shape knot_form() {
  constexpr int kAlong = 480, kAround = 48;
  constexpr double kRope = 0.34;
  // (2, 3): twice around the axis, three times through the middle; upright, so that it can stand.
  const auto path = [](double t) {
    const double r = 1 + 0.5 * std::cos(3 * t);
    return Vec3(r * std::cos(2 * t), 0.62 * std::sin(3 * t), r * std::sin(2 * t));
  };
  Mesh m;
  for (int i = 0; i < kAlong; ++i) {
    const double t = 2 * M_PI * i / kAlong, e = 1e-4;
    const Vec3 p = path(t), tangent = (path(t + e) - path(t - e)).normalized();
    // A frame that closes: use the direction away from the ring's central circle.
    const Vec3 middle(std::cos(2 * t), 0, std::sin(2 * t));
    const Vec3 out = (p - middle) - tangent * tangent.dot(p - middle);
    const Vec3 u = out.normalized(), v = tangent.cross(u);
    for (int j = 0; j < kAround; ++j) {
      const double a = 2 * M_PI * j / kAround;
      m.vertices.push_back(p + kRope * (std::cos(a) * u + std::sin(a) * v));
    }
  }
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      const int a = i * kAround, b = (i + 1) % kAlong * kAround, k = (j + 1) % kAround;
      quad(m, a + j, a + k, b + k, b + j);
    }
  return finished("knot", std::move(m));
}

}  // namespace terrazzo::carving
