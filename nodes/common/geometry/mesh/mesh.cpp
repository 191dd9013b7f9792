#include "nodes/common/geometry/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "nodes/common/geometry/mesh/convex_hull.h"

namespace terrazzo {
namespace {

// A directed edge of a triangle.
struct HalfEdge {
  std::int32_t from = 0, to = 0;
  std::size_t triangle = 0;
  std::int32_t low() const { return std::min(from, to); }
  std::int32_t high() const { return std::max(from, to); }
};

// Half-edges sorted so that those of the same edge are adjacent: by lower vertex, by counting, then each
// vertex's few by the rest.
std::vector<HalfEdge> sorted_half_edges(const Mesh& mesh) {
  std::vector<std::size_t> end(mesh.vertices.size() + 1, 0);
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++end[static_cast<std::size_t>(std::min(t[k], t[(k + 1) % 3])) + 1];
  for (std::size_t v = 1; v < end.size(); ++v) end[v] += end[v - 1];
  std::vector<HalfEdge> edges(mesh.triangles.size() * 3);
  std::vector<std::size_t> next(end.begin(), end.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const HalfEdge e{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3], t};
      edges[next[e.low()]++] = e;
    }
  for (std::size_t v = 0; v + 1 < end.size(); ++v)
    std::sort(edges.begin() + end[v], edges.begin() + end[v + 1], [](const HalfEdge& a, const HalfEdge& b) {
      if (a.high() != b.high()) return a.high() < b.high();
      if (a.from != b.from) return a.from < b.from;
      return a.triangle < b.triangle;
    });
  return edges;
}

Vec3 scaled_normal(const Mesh& mesh, std::size_t t) {
  const auto& v = mesh.triangles[t];
  return (mesh.vertices[v[1]] - mesh.vertices[v[0]]).cross(mesh.vertices[v[2]] - mesh.vertices[v[0]]);
}

// A point near the mesh, so that sums over its triangles lose no digits if it is far from the origin.
Vec3 middle(const Mesh& mesh) {
  if (mesh.vertices.empty()) return Vec3::Zero();
  Vec3 lo = mesh.vertices[0], hi = lo;
  for (const Vec3& v : mesh.vertices) {
    lo = lo.cwiseMin(v);
    hi = hi.cwiseMax(v);
  }
  return (lo + hi) / 2;
}

}  // namespace

double mesh_volume(const Mesh& mesh) {
  const Vec3 o = middle(mesh);
  double six = 0;
  for (const auto& t : mesh.triangles)
    six += (mesh.vertices[t[0]] - o).dot((mesh.vertices[t[1]] - o).cross(mesh.vertices[t[2]] - o));
  return six / 6;
}

double mesh_surface_area(const Mesh& mesh) {
  double twice = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) twice += scaled_normal(mesh, t).norm();
  return twice / 2;
}

Vec3 mesh_centroid(const Mesh& mesh) {
  const Vec3 o = middle(mesh);
  double six = 0;
  Vec3 sum = Vec3::Zero();
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - o, b = mesh.vertices[t[1]] - o, c = mesh.vertices[t[2]] - o;
    const double v = a.dot(b.cross(c));
    six += v;
    sum += v * (a + b + c) / 4;
  }
  return six != 0 ? Vec3(o + sum / six) : o;
}

double mesh_bounding_radius(const Mesh& mesh, const Vec3& center) {
  double r2 = 0;
  for (const Vec3& v : mesh.vertices) r2 = std::max(r2, (v - center).squaredNorm());
  return std::sqrt(r2);
}

double mesh_edge_curvature(const Mesh& mesh) {
  const auto edges = sorted_half_edges(mesh);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
    const HalfEdge &e = edges[i], &f = edges[i + 1];
    const Vec3 side = mesh.vertices[e.to] - mesh.vertices[e.from];
    const double length = side.norm();
    if (length == 0) continue;
    const Vec3 n = scaled_normal(mesh, e.triangle), m = scaled_normal(mesh, f.triangle);
    sum += length * std::atan2(n.cross(m).dot(side) / length, n.dot(m));
  }
  return sum / (4 * std::numbers::pi);
}

double mesh_mean_caliper(const Mesh& mesh) { return mesh_edge_curvature(convex_hull(mesh.vertices)); }

bool mesh_is_convex(const Mesh& mesh, double tolerance) {
  if (!mesh_faults(mesh).empty()) return false;
  const double reach = tolerance * mesh_bounding_radius(mesh, middle(mesh));
  const auto edges = sorted_half_edges(mesh);
  const auto opposite = [&](const HalfEdge& e) {
    for (auto v : mesh.triangles[e.triangle])
      if (v != e.from && v != e.to) return v;
    return e.from;
  };
  for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
    const Vec3 n = scaled_normal(mesh, edges[i].triangle);
    const Vec3 d = mesh.vertices[opposite(edges[i + 1])] - mesh.vertices[edges[i].from];
    if (n.dot(d) > reach * n.norm()) return false;
  }
  // Flat dents that a fine tessellation hides from the edge test, cavities and separate parts all leave a gap
  // to the hull.
  const Mesh hull = convex_hull(mesh.vertices);
  return mesh_volume(hull) - mesh_volume(mesh) <= reach * mesh_surface_area(hull);
}

std::vector<std::string> mesh_faults(const Mesh& mesh) {
  constexpr std::size_t kMost = 10;
  std::vector<std::string> faults;
  std::size_t count = 0;
  const auto add = [&](std::string text) {
    if (++count <= kMost) faults.push_back(std::move(text));
  };
  const std::int32_t n = mesh.vertices.size();
  if (mesh.triangles.empty()) add("the mesh has no triangles");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!mesh.vertices[v].allFinite()) add(fmt::format("vertex {} is not finite", v));
  bool usable = true;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (std::min({a, b, c}) < 0 || std::max({a, b, c}) >= n) {
      add(fmt::format("triangle {} refers to vertices {}, {}, {} of {}", t, a, b, c, n));
      usable = false;
    } else if (a == b || b == c || c == a)
      add(fmt::format("triangle {} uses a vertex twice ({}, {}, {})", t, a, b, c));
  }
  if (!usable) return faults;
  const auto edges = sorted_half_edges(mesh);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i, forward = 0;
    for (; end < edges.size() && edges[end].low() == edges[i].low() && edges[end].high() == edges[i].high();
         ++end)
      forward += edges[end].from == edges[i].low();
    if (end - i != 2 || forward != 1) {
      const Vec3 at = (mesh.vertices[edges[i].from] + mesh.vertices[edges[i].to]) / 2;
      const std::string place = fmt::format("edge {}–{} at ({:.4g}, {:.4g}, {:.4g})", edges[i].low(),
                                            edges[i].high(), at.x(), at.y(), at.z());
      if (end - i == 2)
        add(place + " has the same direction in both triangles: they face opposite sides");
      else
        add(fmt::format("{} has {} triangle{}", place, end - i, end - i == 1 ? "" : "s"));
    }
    i = end;
  }
  if (count > kMost) faults.push_back(fmt::format("and {} more", count - kMost));
  return faults;
}

void transform(Mesh& mesh, const Mat3& linear, const Vec3& offset) {
  for (Vec3& v : mesh.vertices) v = linear * v + offset;
  if (linear.determinant() < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

}  // namespace terrazzo
