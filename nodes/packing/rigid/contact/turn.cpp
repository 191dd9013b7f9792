#include "nodes/packing/rigid/contact/turn.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/directions.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

constexpr std::uint64_t kTurns = 0x7475726e73;
constexpr int kTries = 4000;

using CornerArray = Eigen::Array<float, Eigen::Dynamic, 3>;

// A plane that a sphere's mesh must not cross: n·x ≤ reach, relative to its center, mm at scale 1.
struct Wall {
  Vec3f n;
  float reach;
};

// Largest distance by which the mesh extends beyond a plane. Stops above `enough`.
float beyond(const CornerArray& corners, const std::vector<Wall>& planes, const Quat& turn, float enough) {
  const Eigen::Matrix3f back = turn.toRotationMatrix().transpose().cast<float>();
  float worst = -1e30f;
  for (const Wall& plane : planes) {
    const Vec3f n = back * plane.n;
    const float top = (corners.col(0) * n[0] + corners.col(1) * n[1] + corners.col(2) * n[2]).maxCoeff();
    worst = std::max(worst, top - plane.reach);
    if (worst > enough) return worst;
  }
  return worst;
}

}  // namespace

void turn_spheres(const Shapes& meshes, const std::vector<ContactShape>& shapes, Packing& packing, double gap,
                  std::uint64_t seed, const Work& work) {
  const std::size_t n = packing.count();
  std::vector<CornerArray> corners(shapes.size());
  for (std::int32_t s : packing.shape) {
    if (!(shapes[s].ball > 0) || corners[s].rows() > 0) continue;
    const auto& vertices = meshes.shapes[s].mesh.vertices;
    corners[s].resize(vertices.size(), 3);
    for (std::size_t v = 0; v < vertices.size(); ++v)
      corners[s].row(static_cast<Eigen::Index>(v)) = vertices[v].cast<float>().transpose();
  }
  std::vector<double> radius(n, 0.0);  // of the corners; 0 for bodies that are not spheres
  for (std::size_t i = 0; i < n; ++i)
    if (corners[packing.shape[i]].rows() > 0)
      radius[i] = shapes[packing.shape[i]].bounding_radius * packing.scale[i] * packing.shrink;
  const auto pairs = near_pairs(packing.box, packing.position, radius, gap, work);
  const Incidence incidence = incidence_of(n, pairs);
  // `shared`: each of two neighbors stays on its side of the plane between them. Otherwise it may use the
  // distance that the other one, as it is rotated now, leaves.
  const auto planes_of = [&](std::size_t i, bool shared) {
    std::vector<Wall> planes;
    if (!(radius[i] > 0)) return planes;
    const double scale = packing.scale[i] * packing.shrink;
    for (std::int32_t e = incidence.begin[i]; e < incidence.begin[i + 1]; ++e) {
      const Pair& pair = pairs[incidence.entry[e] >> 1];
      const bool first = (incidence.entry[e] & 1) == 0;
      const std::int32_t other = first ? pair.b : pair.a;
      if (!(radius[other] > 0)) continue;
      const Vec3 offset = offset_of(pair, packing.box, packing.position) * (first ? 1 : -1);
      const double distance = offset.norm();
      if (!(distance > 0)) continue;
      double reach = (distance - gap) * radius[i] / (radius[i] + radius[other]);
      if (!shared) {
        const Wall across{(-offset / distance).cast<float>(), 0};
        const float theirs =
            beyond(corners[packing.shape[other]], {across}, packing.orientation[other], 1e30f);
        reach = std::max(reach, distance - gap - theirs * packing.scale[other] * packing.shrink);
      }
      // Subtract a rounding error of single precision.
      planes.push_back({(offset / distance).cast<float>(), static_cast<float>(reach / scale * (1 - 1e-6))});
    }
    return planes;
  };
  // Returns whether the sphere is behind its planes in the end.
  const auto turn = [&](std::size_t i, const std::vector<Wall>& planes, int tries, std::uint64_t stream) {
    const CornerArray& mesh = corners[packing.shape[i]];
    Quat best = packing.orientation[i];
    float least = beyond(mesh, planes, best, 1e30f);
    Random random(seed, stream, i);
    const double near = 0.5 / std::sqrt(static_cast<double>(mesh.rows()));  // a fraction of a facet
    for (int k = 0; k < tries && least > 0; ++k) {
      if (k % 256 == 255) work.check();
      // Alternate between any rotation and one near the best so far.
      Quat q = random_quaternion(random);
      if (k % 2 == 1) q = Quat(1, near * q.x(), near * q.y(), near * q.z()) * best;
      if (!(q.norm() > 1e-9)) continue;
      q.normalize();
      if (const float f = beyond(mesh, planes, q, least); f < least) {
        least = f;
        best = q;
      }
    }
    packing.orientation[i] = best;
    return least <= 0;
  };
  std::vector<std::uint8_t> stuck(n, 0);
  work.parallel(n, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (const auto planes = planes_of(i, true); !planes.empty())
        stuck[i] = !turn(i, planes, kTries, kTurns);
  });
  for (std::size_t i = 0; i < n; ++i)  // few, one at a time
    if (stuck[i]) turn(i, planes_of(i, false), 4 * kTries, kTurns + 1);
}

}  // namespace terrazzo::packing
