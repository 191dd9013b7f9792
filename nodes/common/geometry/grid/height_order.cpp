#include "nodes/common/geometry/grid/height_order.h"

#include <algorithm>

namespace terrazzo {

HeightOrder::HeightOrder(const Mesh& mesh) : mesh_(mesh), middle_(Vec3::Zero()) {
  if (!mesh.vertices.empty()) {
    Vec3 low = mesh.vertices[0], high = low;
    for (const Vec3& v : mesh.vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    middle_ = (low + high) / 2;
  }
  const std::size_t n = mesh.vertices.size();
  point_.resize(n);
  order_.resize(n);
  rank_.resize(n);
  bucket_.resize(n + 2);
  height_.resize(n);
}

// Bucket sort with as many buckets as vertices, then sorts within each bucket.
void HeightOrder::set(const Vec3& direction) {
  const std::int32_t n = count();
  if (n == 0) return;
  const Vec3 u = direction.normalized(), a = u.unitOrthogonal(), b = u.cross(a);
  double lo = u.dot(mesh_.vertices[0] - middle_), hi = lo;
  for (std::int32_t v = 0; v < n; ++v) {
    const Vec3 x = mesh_.vertices[v] - middle_;
    point_[v] = {a.dot(x), b.dot(x), u.dot(x)};
    lo = std::min(lo, point_[v].z());
    hi = std::max(hi, point_[v].z());
  }
  const double scale = hi > lo ? (n - 1) / (hi - lo) : 0;
  std::fill(bucket_.begin(), bucket_.end(), 0);
  for (std::int32_t v = 0; v < n; ++v) {
    rank_[v] = static_cast<std::int32_t>((point_[v].z() - lo) * scale);
    ++bucket_[rank_[v] + 1];
  }
  for (std::int32_t b2 = 0; b2 <= n; ++b2) bucket_[b2 + 1] += bucket_[b2];
  for (std::int32_t v = 0; v < n; ++v) order_[bucket_[rank_[v]]++] = v;
  const auto below = [&](std::int32_t v, std::int32_t w) {
    return point_[v].z() != point_[w].z() ? point_[v].z() < point_[w].z() : v < w;
  };
  for (std::int32_t k = 0; k < n; ++k) {  // bucket_[k] is now the end of bucket k
    const auto first = order_.begin() + (k > 0 ? bucket_[k - 1] : 0), last = order_.begin() + bucket_[k];
    if (last - first > 1) std::sort(first, last, below);
  }
  for (std::int32_t r = 0; r < n; ++r) {
    rank_[order_[r]] = r;
    height_[r] = point_[order_[r]].z();
  }
}

}  // namespace terrazzo
