#include "nodes/shapes/shape_estimate/from_above.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/shortest_axis.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/outline_features.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/shapes/shape_estimate/rays.h"

namespace terrazzo::shape_estimate {
namespace {

constexpr int kRays = 96;

// Edges of a closed mesh with the triangles on both sides. Only those between a triangle that faces the
// viewer and one that does not can be part of an outline.
struct Edge {
  std::int32_t a, b;              // vertices, a < b
  std::size_t first, second = 0;  // triangles
};
std::vector<Edge> edges_of(const Mesh& mesh) {
  std::vector<Edge> all;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      all.push_back({a, b, t});
    }
  std::sort(all.begin(), all.end(), [](const Edge& x, const Edge& y) {
    return std::tie(x.a, x.b, x.first) < std::tie(y.a, y.b, y.first);
  });
  std::vector<Edge> out;
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    if (all[i].a == all[i + 1].a && all[i].b == all[i + 1].b)
      out.push_back({all[i].a, all[i].b, all[i].first, all[i + 1].first});
  return out;
}

// Whether each triangle faces the viewer, from its shadow.
std::vector<char> faces_viewer(const Mesh& mesh, const std::vector<Vec2>& shadow) {
  std::vector<char> facing;
  for (const Triangle& t : mesh.triangles) {
    const Vec2 u = shadow[t[1]] - shadow[t[0]], v = shadow[t[2]] - shadow[t[0]];
    facing.push_back(u.x() * v.y() - u.y() * v.x() > 0);
  }
  return facing;
}

// The outline of the body's shadow along the last column of `frame`.
Loop silhouette(const Mesh& mesh, const std::vector<Edge>& edges, const Mat3& frame) {
  std::vector<Vec2> shadow;
  Vec2 low = Vec2::Constant(1e300), high = -low;
  for (const Vec3& v : mesh.vertices) {
    shadow.emplace_back(frame.col(0).dot(v), frame.col(1).dot(v));
    low = low.cwiseMin(shadow.back());
    high = high.cwiseMax(shadow.back());
  }
  const Vec2 middle = (low + high) / 2;
  for (Vec2& p : shadow) p -= middle;
  std::vector<double> radius(kRays, 0);
  const std::vector<char> facing = faces_viewer(mesh, shadow);
  for (const Edge& e : edges)
    if (facing[e.first] != facing[e.second]) raise_radii(radius, shadow[e.a], shadow[e.b]);
  return loop_of_radii(radius);
}

// A direction near z. The tilts have a Rayleigh distribution, as of two normal angles.
Vec3 near_z(std::size_t i) {
  const double k = static_cast<double>(i) + 1;
  const double u = std::fmod(0.5 + 0.7548776662466927 * k, 1.0),
               phi = 2 * std::numbers::pi * std::fmod(0.5 + 0.5698402909980532 * k, 1.0);
  const double tilt = std::min(kTilt * std::sqrt(-2 * std::log(1 - u)), std::numbers::pi / 2);
  return {std::sin(tilt) * std::cos(phi), std::sin(tilt) * std::sin(phi), std::cos(tilt)};
}

}  // namespace

std::vector<CutProfile> seen_from_above(const Mesh& mesh, std::size_t views, std::size_t first) {
  std::vector<CutProfile> out;
  const std::vector<Edge> edges = edges_of(mesh);
  for (std::size_t i = 0; i < views; ++i) {
    CutProfile s;
    s.loop = silhouette(mesh, edges, frame_about(near_z(first + i)));
    const double area = loop_area(s.loop);
    if (!(area > 0)) continue;
    s.root_area = std::sqrt(area);
    s.perimeter = loop_perimeter(s.loop);
    out.push_back(std::move(s));
  }
  return out;
}

double assumed_thickness(const std::vector<Outline>& outlines) {
  std::vector<double> ratios;
  for (const Outline& o : outlines) ratios.push_back(outline_features(o.points)[OutlineFeature::Aspect]);
  return ratios.empty() ? 1 : median(std::move(ratios));
}

void lie_down(Mesh& mesh) {
  const auto turn = shortest_axis_up(mesh);
  if (!turn) return;
  for (Vec3& v : mesh.vertices) v = *turn * v;
}

void give_thickness(Mesh& mesh, double ratio) {
  const Loop above = silhouette(mesh, edges_of(mesh), Mat3::Identity());
  // The axes of the ellipse with the silhouette's area and aspect.
  const double area = loop_area(above), aspect = outline_features(above)[OutlineFeature::Aspect];
  const double shorter = std::sqrt(4 * area * aspect / std::numbers::pi);
  double low = 1e300, high = -1e300;
  for (const Vec3& v : mesh.vertices) {
    low = std::min(low, v.z());
    high = std::max(high, v.z());
  }
  if (!(high > low && shorter > 0)) return;
  const double factor = ratio * shorter / (high - low), middle = (low + high) / 2;
  for (Vec3& v : mesh.vertices) v.z() = middle + factor * (v.z() - middle);
}

}  // namespace terrazzo::shape_estimate
