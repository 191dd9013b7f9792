#include "nodes/packing/cells/separating_plane.h"

#include <cmath>

namespace terrazzo::tessellation {
namespace {

const Vec3& farthest(const std::vector<Vec3>& points, const Vec3& direction) {
  std::size_t best = 0;
  double most = -1e300;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (const double h = points[k].dot(direction); h > most) {
      most = h;
      best = k;
    }
  return points[best];
}

}  // namespace

Separation widest_separation(const std::vector<Vec3>& first, const std::vector<Vec3>& second,
                             const Vec3& apart) {
  constexpr int kSteps = 40;
  Separation best;
  Vec3 normal = apart.normalized();
  for (int k = 0; k < kSteps; ++k) {
    const Vec3 from = farthest(first, normal), to = apart + farthest(second, -normal), across = to - from;
    const double gap = normal.dot(across);
    if (k == 0 || gap > best.gap) best = {normal, gap, normal.dot(from), normal.dot(to)};
    const Vec3 sideways = across - gap * normal;  // the gap's gradient over directions
    const double slope = sideways.norm();
    if (!(slope > 1e-6 * apart.norm())) break;
    normal = (normal + 0.5 / (1 + 0.35 * k) * sideways / std::max(slope, across.norm())).normalized();
  }
  return best;
}

}  // namespace terrazzo::tessellation
