#include "nodes/sizes/kmatrix/grid_sweep.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::kmatrix {
namespace {

constexpr int kRanges = 48, kNodes = 2 * kRanges + 1;

}  // namespace

GridSweep::GridSweep(const Mesh& mesh)
    : place_(mesh.vertices.size()), node_depth_(kNodes), node_area_(kNodes), ranges_(kRanges) {
  Vec3 low = mesh.vertices.at(0), high = low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const Vec3 middle = (low + high) / 2;  // areas of a body far from the origin would lose precision
  for (const Vec3& v : mesh.vertices) vertex_.push_back(v - middle);
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = vertex_[t[0]], &b = vertex_[t[1]], &c = vertex_[t[2]];
    const Vec3 area = (b - a).cross(c - a) / 2;
    facets_.push_back({t[0], t[1], t[2], area, area.dot((a + b + c) / 3)});
  }
  const auto end = [](int r) {
    const double s = 2.0 * std::min(r, kRanges - r) / kRanges;
    return 2 * r < kRanges ? s * s / 2 : 1 - s * s / 2;
  };
  for (int r = 0; r <= kRanges; ++r) node_depth_[2 * r] = end(r);
  for (int r = 0; r < kRanges; ++r)
    node_depth_[2 * r + 1] = (node_depth_[2 * r] + node_depth_[2 * r + 2]) / 2;
}

const std::vector<AreaRange>& GridSweep::sweep(const Vec3& direction) {
  const Vec3 u = direction.normalized();
  double lo = u.dot(vertex_[0]), hi = lo;
  for (std::size_t v = 0; v < vertex_.size(); ++v) {
    const double z = place_[v].depth = u.dot(vertex_[v]);
    lo = std::min(lo, z);
    hi = std::max(hi, z);
  }
  std::fill(node_area_.begin(), node_area_.end(), 0.0);
  if (hi > lo) {
    const double height = hi - lo, per_height = 1 / height;
    for (Place& p : place_) {
      p.depth = (p.depth - lo) * per_height;
      const double root = std::sqrt(2 * std::min(p.depth, 1 - p.depth)) * (kRanges / 2);
      p.ordinal = p.depth < 0.5 ? root : kRanges - root;
    }
    for (const Facet& f : facets_) {
      const Place &a = place_[f.a], &b = place_[f.b], &c = place_[f.c];
      const double z0 = std::min(std::min(a.depth, b.depth), c.depth),
                   z2 = std::max(std::max(a.depth, b.depth), c.depth);
      int k = 2 * static_cast<int>(std::min(std::min(a.ordinal, b.ordinal), c.ordinal));
      while (k < kNodes && node_depth_[k] < z0) ++k;
      if (k == kNodes || !(node_depth_[k] <= z2) || !(z2 > z0)) continue;
      const double z1 = a.depth + b.depth + c.depth - z0 - z2;
      const double rise = z1 > z0 ? 1 / (z1 - z0) : 1e300, fall = z2 > z1 ? 1 / (z2 - z1) : 1e300;
      const double slope = f.area.dot(u), scale = per_height / (z2 - z0);
      const double constant = (f.offset - slope * lo) * scale, linear = -slope * height * scale;
      for (; k < kNodes && node_depth_[k] <= z2; ++k) {
        const double z = node_depth_[k];
        node_area_[k] += (constant + linear * z) * std::min(std::min((z - z0) * rise, (z2 - z) * fall), 1.0);
      }
    }
  }
  for (int r = 0; r < kRanges; ++r)
    ranges_[r] = {(node_depth_[2 * r + 2] - node_depth_[2 * r]) * (hi - lo), std::max(0.0, node_area_[2 * r]),
                  std::max(0.0, node_area_[2 * r + 1]), std::max(0.0, node_area_[2 * r + 2])};
  return ranges_;
}

}  // namespace terrazzo::kmatrix
