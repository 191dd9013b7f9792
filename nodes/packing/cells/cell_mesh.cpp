#include "nodes/packing/cells/cell_mesh.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::tessellation {
namespace {

constexpr std::size_t kFewPlanes = 60;
constexpr double kNothing = 1e-6;  // share of the largest term

}  // namespace

Mesh cell_mesh(const ConvexCell& cell) {
  double extent = 0;
  for (const Vec3& c : cell.corners) extent = std::max(extent, (c - cell.centroid).norm());
  const double near = 1e-6 * extent;
  Mesh mesh;
  std::vector<int> merged;
  for (const Vec3& c : cell.corners) {
    const auto same = std::find_if(mesh.vertices.begin(), mesh.vertices.end(),
                                   [&](const Vec3& v) { return (v - c).norm() <= near; });
    merged.push_back(same - mesh.vertices.begin());
    if (same == mesh.vertices.end()) mesh.vertices.push_back(c);
  }
  for (const Face& face : cell.faces) {
    std::vector<int> loop;
    for (int c : face.corners)
      if (loop.empty() || loop.back() != merged[c]) loop.push_back(merged[c]);
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() < 3) continue;  // the faces beside a face without area share its edge
    if (loop.size() == 3) {
      mesh.triangles.push_back({loop[0], loop[1], loop[2]});
      continue;
    }
    Vec3 middle = Vec3::Zero();
    for (int v : loop) middle += mesh.vertices[v] / static_cast<double>(loop.size());
    const int hub = mesh.vertices.size();
    mesh.vertices.push_back(middle);
    for (std::size_t k = 0; k < loop.size(); ++k)
      mesh.triangles.push_back({loop[k], loop[(k + 1) % loop.size()], hub});
  }
  return mesh;
}

void round_edges(Mesh& mesh, const std::vector<Plane>& planes, const Vec3& center, double roundness) {
  if (!(roundness > 0)) return;
  const double power = 3 / roundness;
  // Of many planes, those that add next to nothing to the sum are left out: they would take most of the time.
  const double least = planes.size() > kFewPlanes ? std::pow(kNothing, 1 / power) : 0;
  std::vector<double> shares(planes.size());
  for (Vec3& v : mesh.vertices) {
    const Vec3 r = v - center;
    double largest = 0, sum = 0;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      shares[k] = planes[k].normal.dot(r) / (planes[k].offset - planes[k].normal.dot(center));
      largest = std::max(largest, shares[k]);
    }
    if (!(largest > 0)) continue;
    for (const double h : shares)
      if (h > least * largest) sum += std::pow(h / largest, power);
    v = center + r / (largest * std::pow(sum, 1 / power));
  }
}

}  // namespace terrazzo::tessellation
