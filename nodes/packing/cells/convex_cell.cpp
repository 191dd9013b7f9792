#include "nodes/packing/cells/convex_cell.h"

#include <algorithm>

#include "nodes/packing/cells/voro.h"

namespace terrazzo::tessellation {

ConvexCell convert(voro::voronoicell_neighbor& cell, double unit) {
  ConvexCell c;
  c.volume = cell.volume() * unit * unit * unit;
  cell.centroid(c.centroid[0], c.centroid[1], c.centroid[2]);
  c.centroid *= unit;
  std::vector<double> corners, areas, normals;
  std::vector<int> neighbors, loops;
  cell.vertices(corners);
  cell.face_areas(areas);
  cell.normals(normals);
  cell.neighbors(neighbors);
  cell.face_vertices(loops);
  for (std::size_t k = 0; k + 2 < corners.size(); k += 3)
    c.corners.push_back(unit * Vec3(corners[k], corners[k + 1], corners[k + 2]));
  for (std::size_t f = 0, at = 0; f < neighbors.size(); at += loops[at] + 1, ++f) {
    Face& face = c.faces.emplace_back();
    face.neighbor = neighbors[f];
    face.area = areas[f] * unit * unit;
    face.normal = Vec3(normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]);
    face.corners.assign(loops.begin() + at + 1, loops.begin() + at + 1 + loops[at]);
    std::reverse(face.corners.begin(), face.corners.end());  // Voro++ lists them clockwise
  }
  return c;
}

std::vector<Plane> planes_of(const ConvexCell& cell) {
  std::vector<Plane> planes;
  for (const Face& f : cell.faces)
    planes.push_back({f.normal, f.normal.dot(cell.corners[f.corners[0]]), f.neighbor});
  return planes;
}

ConvexCell cell_between(const std::vector<Plane>& planes, double reach) {
  // Voro++ compares with absolute tolerances, so the cube has edge 2.
  voro::voronoicell_neighbor cell;
  cell.init(-1, 1, -1, 1, -1, 1);
  for (const Plane& p : planes)
    if (!cell.nplane(p.normal[0], p.normal[1], p.normal[2], 2 * p.offset / reach, p.neighbor)) return {};
  ConvexCell c = convert(cell, reach);
  for (Face& f : c.faces)
    if (f.neighbor < 0) f.neighbor = -1;  // Voro++ numbers the cube's faces −1 to −6
  return c;
}

}  // namespace terrazzo::tessellation
