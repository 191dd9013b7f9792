#include "nodes/common/depth_areas.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/mesh.h"

namespace terrazzo {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

double DepthAreas::max_area() const {
  double best = 0;
  for (std::size_t k = 0; k < low.size(); ++k) {
    best = std::max({best, low[k], middle[k], high[k]});
    // The parabola's vertex, where it lies inside.
    const double bend = 2 * (low[k] + high[k] - 2 * middle[k]), slope = high[k] - low[k];
    if (bend < 0 && std::abs(slope) < -bend) best = std::max(best, middle[k] - slope * slope / (8 * bend));
  }
  return best;
}

DepthSweep::DepthSweep(const Mesh& mesh) : mesh_(mesh), radius_(mesh_bounding_radius(mesh)) {
  const std::size_t n = mesh.vertices.size();
  point_.resize(n), order_.resize(n), rank_.resize(n), bucket_.resize(n + 2);
  c0_.resize(n), c1_.resize(n), c2_.resize(n);
  areas_.height.resize(n);
  const std::size_t intervals = n > 0 ? n - 1 : 0;
  areas_.low.resize(intervals), areas_.middle.resize(intervals), areas_.high.resize(intervals);
}

// Ranks of the vertices by height: distributed over as many buckets as there are vertices, then put right
// locally.
void DepthSweep::sort_heights() {
  const auto n = static_cast<std::int32_t>(point_.size());
  double lo = point_[0].z(), hi = lo;
  for (const Vec3& p : point_) lo = std::min(lo, p.z()), hi = std::max(hi, p.z());
  const double scale = hi > lo ? (n - 1) / (hi - lo) : 0;
  std::fill(bucket_.begin(), bucket_.end(), 0);
  for (std::int32_t v = 0; v < n; ++v) {
    rank_[v] = static_cast<std::int32_t>((point_[v].z() - lo) * scale);
    ++bucket_[rank_[v] + 1];
  }
  for (std::int32_t b = 0; b <= n; ++b) bucket_[b + 1] += bucket_[b];
  for (std::int32_t v = 0; v < n; ++v) order_[bucket_[rank_[v]]++] = v;
  const auto less = [&](std::int32_t a, std::int32_t b) {
    return point_[a].z() != point_[b].z() ? point_[a].z() < point_[b].z() : a < b;
  };
  for (std::int32_t b = 0; b < n; ++b) {  // bucket_[b] is now the end of bucket b
    const auto first = order_.begin() + (b > 0 ? bucket_[b - 1] : 0), last = order_.begin() + bucket_[b];
    if (last - first > 1) std::sort(first, last, less);
  }
  for (std::int32_t r = 0; r < n; ++r) {
    rank_[order_[r]] = r;
    areas_.height[r] = point_[order_[r]].z();
  }
}

const DepthAreas& DepthSweep::sweep(const Vec3& direction) {
  const std::size_t n = point_.size();
  if (n < 2) return areas_;
  const Vec3 u = direction.normalized(), a = u.unitOrthogonal(), b = u.cross(a);
  for (std::size_t v = 0; v < n; ++v) {
    const Vec3& x = mesh_.vertices[v];
    point_[v] = {a.dot(x), b.dot(x), u.dot(x)};
  }
  sort_heights();
  std::fill(c0_.begin(), c0_.end(), 0), std::fill(c1_.begin(), c1_.end(), 0),
      std::fill(c2_.begin(), c2_.end(), 0);
  std::fill(areas_.low.begin(), areas_.low.end(), 0);
  std::fill(areas_.middle.begin(), areas_.middle.end(), 0);
  std::fill(areas_.high.begin(), areas_.high.end(), 0);

  // Coefficients grow with the inverse square of a piece's height; the few pieces too flat for that are added
  // to their intervals one by one.
  const double flat = 1e-4 * radius_;
  const auto add = [&](std::int32_t from, std::int32_t to, double sign, const Vec3& p, const Vec3& p_end,
                       const Vec3& q, const Vec3& q_end, std::int32_t low, std::int32_t high) {
    const double dp = p_end.z() - p.z(), dq = q_end.z() - q.z();
    if (!(dp > 0) || !(dq > 0)) return;
    const Vec2 p1 = (p_end - p).head<2>() / dp, q1 = (q_end - q).head<2>() / dq;
    if (areas_.height[high] - areas_.height[low] > flat) {
      const Vec2 p0 = p.head<2>() - p1 * p.z(), q0 = q.head<2>() - q1 * q.z();
      const double k0 = sign * cross(p0, q0), k1 = sign * (cross(p0, q1) + cross(p1, q0)),
                   k2 = sign * cross(p1, q1);
      c0_[from] += k0, c1_[from] += k1, c2_[from] += k2;
      c0_[to] -= k0, c1_[to] -= k1, c2_[to] -= k2;
      return;
    }
    const auto at = [&](double z) {
      const Vec2 x = p.head<2>() + p1 * (z - p.z()), y = q.head<2>() + q1 * (z - q.z());
      return sign * cross(x, y);
    };
    for (std::int32_t k = from; k < to; ++k) {
      const double z0 = areas_.height[k], z1 = areas_.height[k + 1];
      areas_.low[k] += at(z0), areas_.middle[k] += at((z0 + z1) / 2), areas_.high[k] += at(z1);
    }
  };
  for (const auto& t : mesh_.triangles) {
    std::int32_t l = t[0], m = t[1], h = t[2];
    double sign = 0.5;  // the sides from l to m to h to l run as the triangle does
    if (rank_[l] > rank_[m]) std::swap(l, m), sign = -sign;
    if (rank_[m] > rank_[h]) std::swap(m, h), sign = -sign;
    if (rank_[l] > rank_[m]) std::swap(l, m), sign = -sign;
    const Vec3 &pl = point_[l], &pm = point_[m], &ph = point_[h];
    add(rank_[l], rank_[m], sign, pl, ph, pl, pm, rank_[l], rank_[m]);
    add(rank_[m], rank_[h], sign, pl, ph, pm, ph, rank_[m], rank_[h]);
  }
  double k0 = 0, k1 = 0, k2 = 0;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    k0 += c0_[k], k1 += c1_[k], k2 += c2_[k];
    const double z0 = areas_.height[k], z2 = areas_.height[k + 1], z1 = (z0 + z2) / 2;
    areas_.low[k] = std::max(0.0, areas_.low[k] + k0 + z0 * (k1 + z0 * k2));
    areas_.middle[k] = std::max(0.0, areas_.middle[k] + k0 + z1 * (k1 + z1 * k2));
    areas_.high[k] = std::max(0.0, areas_.high[k] + k0 + z2 * (k1 + z2 * k2));
  }
  return areas_;
}

}  // namespace terrazzo
