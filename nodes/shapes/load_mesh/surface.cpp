#include "nodes/shapes/load_mesh/surface.h"

#include <array>
#include <map>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/load_mesh/repair.h"
#include "runtime/memory.h"

namespace terrazzo::load_mesh {
namespace {

constexpr double kBytes = 300;  // of each triangle: its corners, its vertices by position, and the result
constexpr std::size_t kCheckEvery = 4096;

void require_memory_for(const PolygonSoup& soup, std::uint64_t memory) {
  double triangles = 0;
  for (const auto& p : soup.polygons) triangles += static_cast<double>(p.size()) - 2;
  require_memory(kBytes * triangles, memory, "the surface");
}

// Polygons of which every corner is a vertex of its own, so that triangles know their texture coordinates.
struct SplitPolygons {
  PolygonSoup soup;
  std::vector<int> vertex;  // of each corner
  std::vector<Eigen::Vector2f> uv;
};

SplitPolygons split_corners(const PolygonSoup& soup, const Work& work) {
  SplitPolygons out;
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    if (f % kCheckEvery == 0) work.check();
    out.soup.polygons.emplace_back();
    for (std::size_t k = 0; k < soup.polygons[f].size(); ++k) {
      out.soup.polygons.back().push_back(count_of(out.vertex));
      out.vertex.push_back(soup.polygons[f][k]);
      out.soup.vertices.push_back(soup.vertices[out.vertex.back()]);
      if (!soup.uv.empty()) out.uv.push_back(soup.uv[f][k]);
    }
  }
  return out;
}

// Fills the mesh with one vertex for each position. Returns the new number of each vertex.
std::vector<int> join_positions(const std::vector<Vec3>& vertices, Mesh& mesh, const Work& work) {
  std::map<std::array<double, 3>, int> places;
  std::vector<int> name(vertices.size());
  for (std::size_t v = 0; v < name.size(); ++v) {
    if (v % kCheckEvery == 0) work.check();
    const Vec3& p = vertices[v];
    const auto [place, added] =
        places.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, count_of(mesh.vertices));  // −0 is 0
    if (added) mesh.vertices.push_back(p);
    name[v] = place->second;
  }
  return name;
}

}  // namespace

Shape surface_of(const PolygonSoup& soup, std::uint64_t memory, const Work& work) {
  require_memory_for(soup, memory);
  const SplitPolygons corners = split_corners(soup, work);
  const Mesh split = triangles_of(corners.soup, work);
  Shape out;
  const std::vector<int> name = join_positions(soup.vertices, out.mesh, work);
  const auto number = [&](int corner) { return name[corners.vertex[corner]]; };
  for (std::size_t i = 0; i < split.triangles.size(); ++i) {
    if (i % kCheckEvery == 0) work.check();
    const Triangle& t = split.triangles[i];
    out.mesh.triangles.push_back({number(t[0]), number(t[1]), number(t[2])});
    if (!corners.uv.empty()) out.uv.push_back({corners.uv[t[0]], corners.uv[t[1]], corners.uv[t[2]]});
  }
  out.surface_area = mesh_surface_area(out.mesh);
  return out;
}

}  // namespace terrazzo::load_mesh
