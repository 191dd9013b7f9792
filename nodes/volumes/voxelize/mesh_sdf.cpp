#include "nodes/volumes/voxelize/mesh_sdf.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/volumes/voxelize/block_distances.h"

namespace terrazzo::voxelize {

MeshSdf::MeshSdf(const Mesh& mesh, int cells, double band, const Work& work) {
  Eigen::AlignedBox3d bounds;
  for (const auto& v : mesh.vertices) bounds.extend(v);
  spacing_ = bounds.sizes().maxCoeff() / cells;
  far_ = band * spacing_;
  const int margin = round_up(band) + 1;
  origin_ = bounds.min() - Vec3::Constant(margin * spacing_);
  box_.size = ((bounds.sizes() / spacing_).array().ceil().cast<int>() + 2 * margin + 1).matrix();

  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) vertices.push_back((v - origin_) / spacing_);
  Scan scan;
  scan_mesh(vertices, mesh.triangles, box_, 1, scan);

  nodes_.resize(box_.count());
  const AabbTree tree(mesh);
  const Vec3i blocks = (box_.size.array() + kBlock - 1) / kBlock;
  work.parallel(blocks.prod(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const Vec3i lo =
          kBlock * Vec3i(b % blocks.x(), b / blocks.x() % blocks.y(), b / blocks.x() / blocks.y());
      const Vec3i hi = (lo.array() + kBlock).min(box_.size.array());
      block_distances(
          mesh, tree, lo, hi, kBlockReach * spacing_, far_, [](int, int, int) { return true; },
          [&](const Vec3& cell) { return Vec3(origin_ + spacing_ * cell); },
          [&](int i, int j, int k, double d) {
            const std::size_t at = box_.index(i, j, k);
            nodes_[at] = scan.inside[at] ? -d : d;
          });
    }
  });
}

float MeshSdf::at(const Vec3& p) const {
  const Vec3 q = (p - origin_) / spacing_;
  float t[3];
  std::size_t i[3];
  for (int a = 0; a < 3; ++a) {
    if (!(q[a] >= 0) || q[a] >= box_.size[a] - 1) return far_;
    i[a] = static_cast<std::size_t>(q[a]);
    t[a] = q[a] - i[a];
  }
  const std::size_t sx = box_.size.x(), sxy = sx * box_.size.y();
  const float* n = nodes_.data() + i[2] * sxy + i[1] * sx + i[0];
  const auto mix = [](float a, float b, float w) { return a + w * (b - a); };
  const float y0 = mix(mix(n[0], n[1], t[0]), mix(n[sx], n[sx + 1], t[0]), t[1]);
  const float* m = n + sxy;
  return mix(y0, mix(mix(m[0], m[1], t[0]), mix(m[sx], m[sx + 1], t[0]), t[1]), t[2]);
}

}  // namespace terrazzo::voxelize
