#include "nodes/voxelize/closest.h"

#include <algorithm>
#include <numeric>

namespace terrazzo::voxelize {

// Ericson, Real-Time Collision Detection (2005), section 5.1.5: cases by the Voronoi region that contains p's
// projection onto the triangle's plane.
double distance2_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return (bp - w * (c - b)).squaredNorm();
  }
  const double sum = va + vb + vc;
  if (sum <= 0)
    return std::min({ap.squaredNorm(), bp.squaredNorm(), cp.squaredNorm()});  // degenerate triangle
  return (ap - vb / sum * ab - vc / sum * ac).squaredNorm();
}

ClosestTriangle::ClosestTriangle(const Mesh& mesh) : mesh_(mesh), order_(mesh.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Vec3> centers;
  centers.reserve(order_.size());
  for (const auto& t : mesh.triangles)
    centers.push_back((mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3);
  if (!order_.empty()) build(0, static_cast<std::int32_t>(order_.size()), centers);
}

void ClosestTriangle::build(std::int32_t begin, std::int32_t end, const std::vector<Vec3>& centers) {
  const std::size_t at = nodes_.size();
  nodes_.push_back({{}, begin, end, 0});
  Eigen::AlignedBox3d box, middle;
  for (std::int32_t i = begin; i < end; ++i) {
    for (const auto v : mesh_.triangles[order_[i]]) box.extend(mesh_.vertices[v]);
    middle.extend(centers[order_[i]]);
  }
  nodes_[at].box = box;
  if (end - begin <= 4) return;
  Eigen::Index axis;
  middle.sizes().maxCoeff(&axis);
  const std::int32_t half = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end, [&](auto a, auto b) {
    return centers[a][axis] != centers[b][axis] ? centers[a][axis] < centers[b][axis] : a < b;
  });
  build(begin, half, centers);
  nodes_[at].right = static_cast<std::int32_t>(nodes_.size());
  build(half, end, centers);
}

double ClosestTriangle::distance2(const Vec3& p, double bound) const {
  if (nodes_.empty()) return bound;
  std::int32_t stack[64];
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::int32_t at = stack[--depth];
    const Node& node = nodes_[at];
    if (node.box.squaredExteriorDistance(p) >= bound) continue;
    if (node.right == 0) {
      for (std::int32_t i = node.begin; i < node.end; ++i) {
        const Triangle& t = mesh_.triangles[order_[i]];
        bound = std::min(bound, distance2_to_triangle(p, mesh_.vertices[t[0]], mesh_.vertices[t[1]],
                                                      mesh_.vertices[t[2]]));
      }
      continue;
    }
    // Push the nearer child last, so that it is visited first and tightens the bound.
    const std::int32_t left = at + 1, right = node.right;
    const bool left_first =
        nodes_[left].box.squaredExteriorDistance(p) <= nodes_[right].box.squaredExteriorDistance(p);
    stack[depth++] = left_first ? right : left;
    stack[depth++] = left_first ? left : right;
  }
  return bound;
}

}  // namespace terrazzo::voxelize
