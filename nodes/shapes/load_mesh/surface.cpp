#include "nodes/shapes/load_mesh/surface.h"

#include <array>
#include <map>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/load_mesh/repair.h"

namespace terrazzo::load_mesh {

Shape surface_of(const PolygonSoup& soup, const Work& work) {
  // Every corner of a polygon is a vertex of its own, so that triangles know their texture coordinates.
  PolygonSoup corners;
  std::vector<int> vertex;
  std::vector<Eigen::Vector2f> uv;
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    corners.polygons.emplace_back();
    for (std::size_t k = 0; k < soup.polygons[f].size(); ++k) {
      corners.polygons.back().push_back(count_of(vertex));
      vertex.push_back(soup.polygons[f][k]);
      corners.vertices.push_back(soup.vertices[vertex.back()]);
      if (!soup.uv.empty()) uv.push_back(soup.uv[f][k]);
    }
  }
  const Mesh split = triangles_of(corners, work);
  Shape out;
  std::map<std::array<double, 3>, int> places;
  std::vector<int> name(soup.vertices.size());
  for (std::size_t v = 0; v < name.size(); ++v) {
    const Vec3& p = soup.vertices[v];
    const auto [place, added] =
        places.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, count_of(out.mesh.vertices));  // −0 is 0
    if (added) out.mesh.vertices.push_back(p);
    name[v] = place->second;
  }
  for (const Triangle& t : split.triangles) {
    out.mesh.triangles.push_back({name[vertex[t[0]]], name[vertex[t[1]]], name[vertex[t[2]]]});
    if (!uv.empty()) out.uv.push_back({uv[t[0]], uv[t[1]], uv[t[2]]});
  }
  out.surface_area = mesh_surface_area(out.mesh);
  return out;
}

}  // namespace terrazzo::load_mesh
