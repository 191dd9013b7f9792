#include "nodes/packing/rigid/simplify.h"

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/common/geometry/mesh/reduce.h"

namespace terrazzo::packing {
namespace {

constexpr std::size_t kSamples = 4000;

// Largest distance of some thousand of `mesh`'s triangles from another surface; stops beyond `enough`.
double farthest(const Mesh& mesh, const MeshDistance& from, double enough) {
  double worst = 0;
  const std::size_t stride = 1 + mesh.triangles.size() / kSamples;
  for (std::size_t t = 0; t < mesh.triangles.size() && worst <= enough; t += stride) {
    const auto& tri = mesh.triangles[t];
    const Vec3 &a = mesh.vertices[tri[0]], &b = mesh.vertices[tri[1]], &c = mesh.vertices[tri[2]];
    for (const Vec3& p : {a, b, c, Vec3((a + b + c) / 3)})
      worst = std::max(worst, std::abs(from.signed_distance(p, 2 * enough)));
  }
  return worst;
}

}  // namespace

Simplified simplified(const Mesh& mesh, double tolerance, const Work& work, std::size_t fewest, double step) {
  const double count = mesh.triangles.size();
  for (double most = fewest; most <= count / step; most *= step) {
    work.check();
    Mesh fewer = mesh;
    try {
      reduce_triangles(fewer, static_cast<std::size_t>(most), work);
    } catch (const Error&) {
      break;
    }
    const double outside = farthest(mesh, MeshDistance(fewer), tolerance);
    if (outside > tolerance) continue;
    const double inside = farthest(fewer, MeshDistance(mesh), tolerance);
    if (inside <= tolerance) return {std::move(fewer), std::max(outside, inside)};
  }
  return {mesh, 0};
}

}  // namespace terrazzo::packing
