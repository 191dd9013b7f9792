#include "nodes/shapes/load_mesh/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/load_mesh/fill.h"

namespace terrazzo::load_mesh {

namespace {

using Edge = std::pair<int, int>;

Edge edge_of(int a, int b) { return std::minmax(a, b); }

// The triangles at each undirected edge.
std::map<Edge, std::vector<int>> edge_triangles(const Mesh& mesh) {
  std::map<Edge, std::vector<int>> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      edges[edge_of(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3])].push_back(static_cast<int>(t));
  return edges;
}

bool runs(const Triangle& t, int a, int b) {
  return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
}

std::size_t drop_vanished_triangles(Mesh& mesh) {
  return std::erase_if(mesh.triangles,
                       [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

std::size_t drop_doubles(Mesh& mesh) {
  std::set<Triangle> seen;
  return std::erase_if(mesh.triangles, [&](Triangle t) {
    std::sort(t.begin(), t.end());
    return !seen.insert(t).second;
  });
}

std::size_t drop_unused_vertices(Mesh& mesh) {
  std::vector<int> name(mesh.vertices.size(), -1);
  std::vector<Vec3> kept;
  for (auto& t : mesh.triangles)
    for (auto& v : t) {
      if (name[v] < 0) {
        name[v] = kept.size();
        kept.push_back(mesh.vertices[v]);
      }
      v = name[v];
    }
  const auto dropped = mesh.vertices.size() - kept.size();
  mesh.vertices = std::move(kept);
  return dropped;
}

// Orients each connected part like its first triangle, then flips a part that is inside out. Parts that were
// consistent from the start keep their orientation, since one may be a cavity of another, unless the mesh as
// a whole encloses a negative volume.
std::size_t orient(Mesh& mesh, const Work& work) {
  const auto edges = edge_triangles(mesh);
  const auto before = mesh.triangles;
  std::vector<int> part(mesh.triangles.size(), -1);
  std::vector<std::vector<int>> parts;
  std::vector<bool> agreed;
  for (std::size_t start = 0; start < mesh.triangles.size(); ++start) {
    if (part[start] >= 0) continue;
    parts.emplace_back();
    agreed.push_back(true);
    std::vector<int> open{static_cast<int>(start)};
    part[start] = count_of(parts) - 1;
    while (!open.empty()) {
      work.check();
      const int t = open.back();
      open.pop_back();
      parts.back().push_back(t);
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
        const auto& two = edges.at(edge_of(a, b));
        if (two.size() != 2) continue;
        const int other = two[0] == t ? two[1] : two[0];
        if (part[other] >= 0) continue;
        part[other] = part[t];
        if (runs(mesh.triangles[other], a, b)) {
          std::swap(mesh.triangles[other][1], mesh.triangles[other][2]);
          agreed.back() = false;
        }
        open.push_back(other);
      }
    }
  }
  auto volume_of = [&](const std::vector<int>& which) {
    Mesh m;
    m.vertices = mesh.vertices;
    for (const int t : which) m.triangles.push_back(mesh.triangles[t]);
    return mesh_volume(m);
  };
  auto turn = [&](const std::vector<int>& which) {
    for (const int t : which) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  };
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (!agreed[p] && volume_of(parts[p]) < 0) turn(parts[p]);
  if (mesh_volume(mesh) < 0)
    for (const auto& p : parts) turn(p);
  std::size_t turned = 0;
  for (std::size_t t = 0; t < before.size(); ++t) turned += before[t] != mesh.triangles[t];
  return turned;
}

// Loops of edges with a single triangle, in the direction of the triangles that would fill them.
std::vector<std::vector<int>> holes(const Mesh& mesh) {
  std::map<int, std::vector<int>> next;
  for (const auto& [edge, two] : edge_triangles(mesh)) {
    if (two.size() != 1) continue;
    auto [a, b] = edge;
    if (runs(mesh.triangles[two[0]], a, b)) std::swap(a, b);
    next[a].push_back(b);
  }
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int> path{next.begin()->first};
    std::map<int, std::size_t> seen{{path[0], 0}};
    for (;;) {
      const auto found = next.find(path.back());
      if (found == next.end()) break;  // not a loop: there are non-manifold edges nearby
      const int to = found->second.back();
      found->second.pop_back();
      if (found->second.empty()) next.erase(found);
      const auto again = seen.find(to);
      if (again == seen.end()) {
        seen[to] = path.size();
        path.push_back(to);
        continue;
      }
      // A vertex reached twice closes a loop. Continue with the path that led to it.
      loops.emplace_back(path.begin() + again->second, path.end());
      for (std::size_t i = again->second + 1; i < path.size(); ++i) seen.erase(path[i]);
      path.resize(again->second + 1);
    }
  }
  return loops;
}

}  // namespace

Mesh triangles_of(const PolygonSoup& soup, const Work& work) {
  Mesh mesh;
  mesh.vertices = soup.vertices;
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    work.check();
    const auto& p = soup.polygons[f];
    std::vector<Vec3> at;
    for (const int v : p) at.push_back(soup.vertices[v]);
    const auto cover = least_area_triangulation(at);
    if (!cover.empty()) {
      for (const auto& t : cover) mesh.triangles.push_back({p[t[0]], p[t[1]], p[t[2]]});
      continue;
    }
    Vec3 normal = Vec3::Zero();
    for (std::size_t i = 1; i + 1 < at.size(); ++i) normal += (at[i] - at[0]).cross(at[i + 1] - at[0]);
    for (std::size_t i = 1; i + 1 < at.size(); ++i) {
      if ((at[i] - at[0]).cross(at[i + 1] - at[0]).dot(normal) < 0)
        throw Error("bad-mesh", fmt::format("face {} has {} corners and is not convex", f, p.size()),
                    "triangulate the mesh in the program that wrote it");
      mesh.triangles.push_back({p[0], p[i], p[i + 1]});
    }
  }
  return mesh;
}

std::size_t weld(Mesh& mesh, double distance) {
  const int n = mesh.vertices.size();
  std::vector<int> name(n);
  if (distance <= 0) {
    std::map<std::array<double, 3>, int> at;
    for (int v = 0; v < n; ++v) {
      const Vec3& p = mesh.vertices[v];
      name[v] = at.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, v).first->second;  // −0 + 0 is 0
    }
  } else {
    // The first vertex of a neighborhood replaces the later ones. Grid cells as wide as the distance hold the
    // candidates.
    std::map<std::array<std::int64_t, 3>, std::vector<int>> cells;
    const auto cell = [&](double x) { return static_cast<std::int64_t>(std::floor(x / distance)); };
    Vec3 low = mesh.vertices.empty() ? Vec3::Zero() : mesh.vertices[0];
    for (const auto& p : mesh.vertices) low = low.cwiseMin(p);
    for (int v = 0; v < n; ++v) {
      const Vec3 p = mesh.vertices[v] - low;
      const std::array<std::int64_t, 3> c{cell(p.x()), cell(p.y()), cell(p.z())};
      name[v] = v;
      for (int i = 0; i < 27 && name[v] == v; ++i) {
        const auto found = cells.find({c[0] + i % 3 - 1, c[1] + i / 3 % 3 - 1, c[2] + i / 9 - 1});
        if (found == cells.end()) continue;
        for (const int other : found->second)
          if ((mesh.vertices[other] - mesh.vertices[v]).norm() <= distance) {
            name[v] = other;
            break;
          }
      }
      if (name[v] == v) cells[c].push_back(v);
    }
  }
  std::size_t gone = 0;
  for (int v = 0; v < n; ++v) gone += name[v] != v;
  if (gone == 0) return 0;
  for (auto& t : mesh.triangles)
    for (auto& v : t) v = name[v];
  drop_vanished_triangles(mesh);
  drop_unused_vertices(mesh);
  return gone;
}

std::vector<std::string> repair(Mesh& mesh, const Work& work) {
  std::vector<std::string> done;
  const auto tell = [&](std::size_t n, const char* one, const char* many) {
    if (n) done.push_back(fmt::format(fmt::runtime(n == 1 ? one : many), n));
  };
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (!mesh.vertices.empty()) low = high = mesh.vertices[0];
  for (const auto& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const auto triangles = mesh.triangles.size();
  tell(weld(mesh, 1e-6 * (high - low).norm()), "joined {} vertex with its duplicate",
       "joined {} vertices with their duplicates");
  drop_vanished_triangles(mesh);
  tell(triangles - mesh.triangles.size(), "dropped {} degenerate triangle",
       "dropped {} degenerate triangles");
  tell(drop_doubles(mesh), "dropped {} duplicate triangle", "dropped {} duplicate triangles");
  drop_unused_vertices(mesh);
  std::size_t turned = orient(mesh, work);

  std::size_t filled = 0, added = 0;
  std::set<Edge> taken;
  for (const auto& [edge, two] : edge_triangles(mesh)) taken.insert(edge);
  for (const auto& loop : holes(mesh)) {
    work.check();
    std::vector<Vec3> rim;
    for (const int v : loop) rim.push_back(mesh.vertices[v]);
    const auto cover = least_area_triangulation(
        rim, [&](int i, int j) { return taken.count(edge_of(loop[i], loop[j])) > 0; });
    if (cover.empty()) continue;
    for (const auto& t : cover) {
      mesh.triangles.push_back({loop[t[0]], loop[t[1]], loop[t[2]]});
      for (int k = 0; k < 3; ++k) taken.insert(edge_of(loop[t[k]], loop[t[(k + 1) % 3]]));
    }
    ++filled;
    added += cover.size();
  }
  // Only once the holes are closed does the sign of the volume tell which side faces out.
  if (mesh_volume(mesh) < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    turned = mesh.triangles.size() - added - std::min(turned, mesh.triangles.size() - added);
  }
  tell(turned, "flipped {} triangle", "flipped {} triangles");
  if (filled)
    done.push_back(fmt::format("filled {} hole{} with {} triangle{}", filled, filled == 1 ? "" : "s", added,
                               added == 1 ? "" : "s"));
  return done;
}

}  // namespace terrazzo::load_mesh
