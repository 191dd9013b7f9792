#include "nodes/packing/rigid/contact/polytope.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace terrazzo::packing {
namespace {

struct Plane {
  Vec3 normal = Vec3::Zero();
  double offset = 0;
};

// The plane of each triangle, −1 if it has no area; empty if there are more than `most` planes.
std::vector<int> planes_of(const Mesh& mesh, double radius, std::size_t most, std::vector<Plane>& planes) {
  std::vector<int> of(mesh.triangles.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    const Vec3& o = mesh.vertices[tri[0]];
    const Vec3 n = (mesh.vertices[tri[1]] - o).cross(mesh.vertices[tri[2]] - o);
    if (!(n.norm() > 1e-12 * radius * radius)) continue;
    const Vec3 unit = n.normalized();
    const double offset = unit.dot(o);
    for (std::size_t k = 0; k < planes.size() && of[t] < 0; ++k)
      if ((planes[k].normal - unit).norm() < 1e-5 && std::abs(planes[k].offset - offset) < 1e-5 * radius)
        of[t] = k;
    if (of[t] >= 0) continue;
    of[t] = planes.size();
    planes.push_back({unit, offset});
    if (planes.size() > most) return {};
  }
  return of;
}

}  // namespace

Polytope make_polytope(const Mesh& mesh, std::size_t most) {
  double radius = 0;
  for (const auto& v : mesh.vertices) radius = std::max(radius, v.norm());
  std::vector<Plane> planes;
  const auto plane_of = planes_of(mesh, radius, most, planes);
  if (plane_of.empty() || planes.size() < 4) return {};
  for (auto& p : planes)  // reject vertices beyond a plane, except for rounding
    for (const auto& v : mesh.vertices) {
      if (p.normal.dot(v) > p.offset + 1e-5 * radius) return {};
      p.offset = std::max(p.offset, p.normal.dot(v));
    }

  // Directed edges between faces form the boundary loop of each face.
  std::map<std::pair<int, int>, int> directed;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (plane_of[t] >= 0)
      for (int k = 0; k < 3; ++k)
        directed[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = plane_of[t];
  std::vector<std::map<int, int>> next(planes.size());
  Polytope p;
  std::map<int, std::int32_t> index;
  const auto vertex = [&](int v) {
    const auto [at, fresh] = index.try_emplace(v, static_cast<std::int32_t>(p.vertices.size()));
    if (fresh) p.vertices.push_back(mesh.vertices[v].cast<float>());
    return at->second;
  };
  for (const auto& [key, face] : directed) {
    const auto twin = directed.find({key.second, key.first});
    if (twin == directed.end()) return {};  // a triangle without area is in between
    if (twin->second == face) continue;
    if (!next[face].emplace(key.first, key.second).second) return {};
    if (key.first < key.second) {
      const Vec3 along = mesh.vertices[key.second] - mesh.vertices[key.first];
      if (!(along.norm() > 0)) return {};
      p.edges.push_back(
          {vertex(key.first), vertex(key.second), along.normalized().cast<float>(), face, twin->second});
    }
  }
  for (std::size_t f = 0; f < planes.size(); ++f) {
    Polytope::Face face{planes[f].normal.cast<float>(), static_cast<float>(planes[f].offset), {}};
    if (next[f].empty()) return {};
    const int first = next[f].begin()->first;
    int v = first;
    do {
      face.loop.push_back(vertex(v));
      const auto at = next[f].find(v);
      if (at == next[f].end() || face.loop.size() > next[f].size()) return {};
      v = at->second;
    } while (v != first);
    if (face.loop.size() != next[f].size()) return {};
    p.faces.push_back(std::move(face));
  }
  return p;
}

}  // namespace terrazzo::packing
