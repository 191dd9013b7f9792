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

// Turns the spheres of a packing, whose positions stay.
class SphereTurner {
 public:
  SphereTurner(const Shapes& meshes, const std::vector<ContactShape>& shapes, Packing& packing, double gap,
               std::uint64_t seed, const Work& work)
      : packing_(packing),
        gap_(gap),
        seed_(seed),
        work_(work),
        corners_(shapes.size()),
        radius_(packing.count(), 0.0) {
    for (std::int32_t s : packing.shape) {
      if (!(shapes[s].ball > 0) || corners_[s].rows() > 0) continue;
      const auto& vertices = meshes.shapes[s].mesh.vertices;
      corners_[s].resize(vertices.size(), 3);
      for (std::size_t v = 0; v < vertices.size(); ++v)
        corners_[s].row(v) = vertices[v].cast<float>().transpose();
    }
    for (std::size_t i = 0; i < radius_.size(); ++i)
      if (corners_[packing.shape[i]].rows() > 0)
        radius_[i] = shapes[packing.shape[i]].bounding_radius * packing.scale[i] * packing.shrink;
    pairs_ = near_pairs(packing.box, packing.position, radius_, gap, work);
    incidence_ = incidence_of(packing.count(), pairs_);
  }

  // The planes that a sphere must stay behind. `shared`: each of two neighbors stays on its side of the plane
  // between them. Otherwise it may use the distance that the other one, as it is rotated now, leaves.
  std::vector<Wall> planes_of(std::size_t i, bool shared) const {
    std::vector<Wall> planes;
    if (!(radius_[i] > 0)) return planes;
    const double scale = packing_.scale[i] * packing_.shrink;
    for (std::int32_t e = incidence_.begin[i]; e < incidence_.begin[i + 1]; ++e) {
      const Pair& pair = pairs_[incidence_.entry[e] >> 1];
      const bool first = (incidence_.entry[e] & 1) == 0;
      const std::int32_t other = first ? pair.b : pair.a;
      if (!(radius_[other] > 0)) continue;
      const Vec3 offset = offset_of(pair, packing_.box, packing_.position) * (first ? 1 : -1);
      const double distance = offset.norm();
      if (!(distance > 0)) continue;
      double reach = (distance - gap_) * radius_[i] / (radius_[i] + radius_[other]);
      if (!shared) {
        const Wall across{(-offset / distance).cast<float>(), 0};
        const float theirs =
            beyond(corners_[packing_.shape[other]], {across}, packing_.orientation[other], 1e30f);
        reach = std::max(reach, distance - gap_ - theirs * packing_.scale[other] * packing_.shrink);
      }
      // Subtract a rounding error of single precision.
      planes.push_back({(offset / distance).cast<float>(), static_cast<float>(reach / scale * (1 - 1e-6))});
    }
    return planes;
  }

  // Returns whether the sphere is behind its planes in the end.
  bool turn(std::size_t i, const std::vector<Wall>& planes, int tries, std::uint64_t stream) {
    const CornerArray& mesh = corners_[packing_.shape[i]];
    Quat best = packing_.orientation[i];
    float least = beyond(mesh, planes, best, 1e30f);
    Random random(seed_, stream, i);
    const double near = 0.5 / std::sqrt(static_cast<double>(mesh.rows()));  // a fraction of a facet
    for (int k = 0; k < tries && least > 0; ++k) {
      if (k % 256 == 255) work_.check();
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
    packing_.orientation[i] = best;
    return least <= 0;
  }

 private:
  Packing& packing_;
  double gap_;
  std::uint64_t seed_;
  const Work& work_;
  std::vector<CornerArray> corners_;  // by shape
  std::vector<double> radius_;        // of the corners; 0 for bodies that are not spheres
  std::vector<Pair> pairs_;
  Incidence incidence_;
};

}  // namespace

void turn_spheres(const Shapes& meshes, const std::vector<ContactShape>& shapes, Packing& packing, double gap,
                  std::uint64_t seed, const Work& work) {
  SphereTurner turner(meshes, shapes, packing, gap, seed, work);
  const std::size_t n = packing.count();
  std::vector<std::uint8_t> stuck(n, 0);
  work.parallel(n, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (const auto planes = turner.planes_of(i, true); !planes.empty())
        stuck[i] = !turner.turn(i, planes, kTries, kTurns);
  });
  for (std::size_t i = 0; i < n; ++i)  // few, one at a time
    if (stuck[i]) turner.turn(i, turner.planes_of(i, false), 4 * kTries, kTurns + 1);
}

}  // namespace terrazzo::packing
