#include "nodes/common/stereology/depth_areas.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/mesh.h"

namespace terrazzo {

double max_area(const AreaRange& r) {
  const double best = std::max({r.low, r.middle, r.high});
  // The vertex of the parabola, if it is inside the range.
  const double bend = 2 * (r.low + r.high - 2 * r.middle), slope = r.high - r.low;
  return bend < 0 && std::abs(slope) < -bend ? std::max(best, r.middle - slope * slope / (8 * bend)) : best;
}

DepthSweep::DepthSweep(const Mesh& mesh)
    : mesh_(mesh),
      order_(mesh),
      flat_(1e-4 * mesh_bounding_radius(mesh, mesh.vertices.empty() ? Vec3(Vec3::Zero()) : mesh.vertices[0])),
      difference_(mesh.vertices.size()),
      ranges_(mesh.vertices.empty() ? 0 : mesh.vertices.size() - 1) {}

const std::vector<AreaRange>& DepthSweep::sweep(const Vec3& direction) {
  order_.set(direction);
  std::fill(difference_.begin(), difference_.end(), Quadratic{});
  for (std::size_t k = 0; k < ranges_.size(); ++k)
    ranges_[k] = {order_.height(static_cast<std::int32_t>(k) + 1) - order_.height(k), 0, 0, 0};

  const auto add = [&](const Chord& chord, std::int32_t from, std::int32_t to) {
    if (!chord.valid()) return;
    if (order_.height(to) - order_.height(from) > flat_) {
      const Quadratic q = chord.area();
      difference_[from] += q;
      difference_[to] -= q;
      return;
    }
    for (std::int32_t k = from; k < to; ++k) {
      const double z0 = order_.height(k), z1 = order_.height(k + 1);
      ranges_[k].low += chord.area(z0);
      ranges_[k].high += chord.area(z1);
      ranges_[k].middle += chord.area((z0 + z1) / 2);
    }
  };
  for (const Triangle& t : mesh_.triangles) {
    const RankedTriangle r(order_, t);
    const std::int32_t low = order_.rank(r.low), middle = order_.rank(r.middle), high = order_.rank(r.high);
    add(r.lower(order_), low, middle);
    add(r.upper(order_), middle, high);
  }
  Quadratic sum;
  for (std::size_t k = 0; k < ranges_.size(); ++k) {
    sum += difference_[k];
    const double z0 = order_.height(k), z1 = z0 + ranges_[k].thickness;
    ranges_[k].low = std::max(0.0, ranges_[k].low + sum(z0));
    ranges_[k].middle = std::max(0.0, ranges_[k].middle + sum((z0 + z1) / 2));
    ranges_[k].high = std::max(0.0, ranges_[k].high + sum(z1));
  }
  return ranges_;
}

}  // namespace terrazzo
