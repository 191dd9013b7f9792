#include "nodes/voxelize/slab.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::voxelize {

Slab::Slab(const Vec3i& lattice, int z0, int z1, bool has_voids) : z0(z0), z1(z1), lattice(lattice) {
  const std::size_t n = static_cast<std::size_t>(lattice.x()) * lattice.y() * (z1 - z0);
  coverage.assign(n, 0), color.assign(n, Vec3f::Zero());
  distance.assign(n, static_cast<float>(kBand)), id.assign(n, -1);
  if (has_voids) holes.assign(n, 0);
}

void make_stamp(Stamp& stamp, const Particles& particles, const Shape& shape, const MeshSdf& sdf,
                double voxel) {
  const std::size_t p = static_cast<std::size_t>(stamp.particle);
  const double scale = particles.scale[p];
  const Mat3 turn = particles.orientation[p].toRotationMatrix();
  const Vec3 center =
      particles.position[p] / voxel - Vec3::Constant(0.5);  // cell centers have integer coordinates
  std::vector<Vec3> vertices;
  vertices.reserve(shape.mesh.vertices.size());
  Eigen::AlignedBox3d bounds;
  for (const auto& v : shape.mesh.vertices) {
    vertices.push_back(center + turn * v * (scale / voxel));
    bounds.extend(vertices.back());
  }
  // Small particles have few voxels to average over, so each voxel gets more lines.
  const double extent = bounds.sizes().minCoeff();
  const int lines = extent > 24 ? 13 : extent > 6 ? 21 : extent > 2 ? 55 : 89;
  scan_mesh(vertices, shape.mesh.triangles, stamp.box, lines, stamp.scan);

  const Mat3 to_mesh = turn.transpose() * (voxel / scale);
  const float unit = static_cast<float>(scale / voxel), band = static_cast<float>(kBand);
  stamp.distance.resize(stamp.box.count());
  std::size_t at = 0;
  for (int k = 0; k < stamp.box.size.z(); ++k)
    for (int j = 0; j < stamp.box.size.y(); ++j) {
      Vec3 q = to_mesh * ((stamp.box.lo + Vec3i(0, j, k)).cast<double>() - center);
      for (int i = 0; i < stamp.box.size.x(); ++i, ++at, q += to_mesh.col(0)) {
        // The scan's sign is exact; the sign of an interpolated distance is unreliable very near the surface.
        const float d = std::min(std::abs(sdf.at(q)) * unit, band);
        stamp.distance[at] = stamp.scan.inside[at] ? -d : d;
      }
    }
}

void add_stamps(Slab& slab, const std::vector<Stamp>& stamps, const Particles& particles, const Work& work) {
  const auto wrap = [](int i, int n) { return ((i % n) + n) % n; };
  const int nx = slab.lattice.x(), ny = slab.lattice.y(), nz = slab.lattice.z();
  work.parallel(slab.z1 - slab.z0, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t plane = begin; plane < end; ++plane)
      for (const Stamp& s : stamps) {
        const Vec3f color = particles.color[s.particle];
        const bool hole = particles.is_void(s.particle);
        const Vec3i lo = s.box.lo, hi = s.box.lo + s.box.size;
        // Every nz-th plane of the stamp maps to this plane.
        const int z = slab.z0 + static_cast<int>(plane);
        for (int k = lo.z() + wrap(z - lo.z(), nz); k < hi.z(); k += nz)
          for (int j = lo.y(); j < hi.y(); ++j) {
            const std::size_t row = slab.index(0, wrap(j, ny), static_cast<int>(plane));
            std::size_t from = s.box.index(lo.x(), j, k);
            int x = wrap(lo.x(), nx);
            for (int i = lo.x(); i < hi.x(); ++i, ++from, x = x + 1 == nx ? 0 : x + 1) {
              const std::size_t to = row + x;
              if (!hole) slab.distance[to] = std::min(slab.distance[to], s.distance[from]);
              const float c = s.scan.coverage[from];
              if (c == 0) continue;
              if (hole) {
                slab.holes[to] += c;
              } else {
                slab.coverage[to] += c;
                slab.color[to] += c * color;
              }
              if (s.scan.inside[from] && slab.id[to] < 0) slab.id[to] = s.particle;
            }
          }
      }
  });
}

}  // namespace terrazzo::voxelize
