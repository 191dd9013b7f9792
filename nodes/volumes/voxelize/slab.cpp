#include "nodes/volumes/voxelize/slab.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"
#include "nodes/volumes/voxelize/block_distances.h"

namespace terrazzo::voxelize {

Slab::Slab(const Vec3i& lattice, int z0, int z1, bool has_voids) : z0(z0), z1(z1), lattice(lattice) {
  const std::size_t n = pixels_in(lattice.x(), lattice.y()) * (z1 - z0);
  coverage.assign(n, 0);
  owner.assign(n, kNone);
  shares.resize(z1 - z0);
  distance.assign(n, static_cast<float>(kBand));
  id.assign(n, -1);
  if (has_voids) holes.assign(n, 0);
}

std::size_t Slab::bytes() const {
  std::size_t out =
      sizeof(*this) + 4 * (coverage.size() + owner.size() + distance.size() + id.size() + holes.size());
  for (const auto& plane : shares) out += sizeof(plane) + plane.capacity() * sizeof(Share);
  return out;
}

namespace {

// Unsigned distances in voxels from the cells of the box to the mesh, clamped to the band. `to_mesh` turns
// cell coordinates relative to `center` into those of the mesh, whose unit is `unit` voxels.
// Cells that are not `needed` are left out.
void exact_distances(const Mesh& mesh, const CellBox& box, const Mat3& to_mesh, const Vec3& center,
                     double unit, const std::vector<std::uint8_t>& needed, std::vector<float>& distance) {
  const AabbTree tree(mesh);
  const auto in_mesh = [&](const Vec3& cell) {
    return Vec3(to_mesh * (box.lo.cast<double>() + cell - center));
  };
  const auto at = [&](int i, int j, int k) {
    return box.index(box.lo.x() + i, box.lo.y() + j, box.lo.z() + k);
  };
  for (int z = 0; z < box.size.z(); z += kBlock)
    for (int y = 0; y < box.size.y(); y += kBlock)
      for (int x = 0; x < box.size.x(); x += kBlock) {
        const Vec3i lo(x, y, z), hi = (lo.array() + kBlock).min(box.size.array());
        block_distances(
            mesh, tree, lo, hi, kBlockReach / unit, kBand / unit,
            [&](int i, int j, int k) { return needed[at(i, j, k)] != 0; }, in_mesh,
            [&](int i, int j, int k, double d) { distance[at(i, j, k)] = d * unit; });
      }
}

void sampled_distances(const MeshSdf& sdf, const CellBox& box, const Mat3& to_mesh, const Vec3& center,
                       double unit, const std::vector<std::uint8_t>& needed, std::vector<float>& distance) {
  const float to_voxels = unit, band = kBand;
  std::size_t at = 0;
  for (int k = 0; k < box.size.z(); ++k)
    for (int j = 0; j < box.size.y(); ++j) {
      Vec3 q = to_mesh * ((box.lo + Vec3i(0, j, k)).cast<double>() - center);
      for (int i = 0; i < box.size.x(); ++i, ++at, q += to_mesh.col(0))
        if (needed[at]) distance[at] = std::min(std::abs(sdf.at(q)) * to_voxels, band);
    }
}

// Turns lattice cells, relative to the particle's center, into coordinates of its mesh, and back.
struct Pose {
  double scale;  // voxels per unit of the mesh
  Mat3 turn;
  Vec3 center;  // cell centers have integer coordinates
  Pose(const Particles& particles, std::size_t p, double voxel)
      : scale(particles.scale[p] / voxel),
        turn(particles.orientation[p].toRotationMatrix()),
        center(particles.position[p] / voxel - Vec3::Constant(0.5)) {}
};

// Calls visit(cell of the slab, cell of the stamp) for the stamp's cells in plane `plane` of the slab, into
// which every nz-th plane of the stamp is wrapped.
template <class Visit>
void visit_plane(const Slab& slab, const Stamp& s, std::size_t plane, Visit&& visit) {
  const int nx = slab.lattice.x(), ny = slab.lattice.y(), nz = slab.lattice.z();
  const Vec3i lo = s.box.lo, hi = s.box.lo + s.box.size;
  const int z = slab.z0 + static_cast<int>(plane);
  for (int k = lo.z() + wrap_index(z - lo.z(), nz); k < hi.z(); k += nz)
    for (int j = lo.y(); j < hi.y(); ++j) {
      const std::size_t row = slab.index(0, wrap_index(j, ny), plane);
      std::size_t from = s.box.index(lo.x(), j, k);
      int x = wrap_index(lo.x(), nx);
      for (int i = lo.x(); i < hi.x(); ++i, ++from, x = x + 1 == nx ? 0 : x + 1) visit(row + x, from);
    }
}

void share(Slab& slab, std::size_t plane, std::size_t at, std::int32_t particle, float cover) {
  const std::uint32_t cell = at - slab.index(0, 0, plane);
  std::int32_t& owner = slab.owner[at];
  if (owner == Slab::kNone) {
    owner = particle;
  } else {
    if (owner != Slab::kSeveral) slab.shares[plane].push_back({cell, owner, slab.coverage[at]});
    slab.shares[plane].push_back({cell, particle, cover});
    owner = Slab::kSeveral;
  }
  slab.coverage[at] += cover;
}

}  // namespace

void scan_stamp(Stamp& stamp, const Particles& particles, const Shape& shape, double voxel) {
  const Pose pose(particles, static_cast<std::size_t>(stamp.particle), voxel);
  std::vector<Vec3> vertices;
  vertices.reserve(shape.mesh.vertices.size());
  Eigen::AlignedBox3d bounds;
  for (const auto& v : shape.mesh.vertices) {
    vertices.push_back(pose.center + pose.turn * v * pose.scale);
    bounds.extend(vertices.back());
  }
  // Small particles have few voxels to average over, so each voxel gets more lines.
  const double extent = bounds.sizes().minCoeff();
  const int lines = extent > 6 ? 13 : extent > 2 ? 55 : 89;
  scan_mesh(vertices, shape.mesh.triangles, stamp.box, lines, stamp.scan);
}

void mark_inside(const Slab& slab, const std::vector<Stamp>& stamps, const Particles& particles,
                 std::vector<std::uint8_t>& taken, const Work& work) {
  work.parallel(slab.z1 - slab.z0, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t plane = begin; plane < end; ++plane)
      for (const Stamp& s : stamps)
        if (!particles.is_void(s.particle))
          visit_plane(slab, s, plane, [&](std::size_t to, std::size_t from) {
            if (s.scan.inside[from]) taken[to] = 1;
          });
  });
}

void add_distances(Stamp& stamp, const Slab& slab, const std::vector<std::uint8_t>& taken,
                   const Particles& particles, const Shape& shape, const MeshSdf* sdf, double voxel) {
  std::vector<std::uint8_t> needed = stamp.scan.inside;
  for (std::size_t plane = 0; plane < static_cast<std::size_t>(slab.z1 - slab.z0); ++plane)
    visit_plane(slab, stamp, plane, [&](std::size_t to, std::size_t from) { needed[from] |= !taken[to]; });
  const std::size_t p = stamp.particle;
  const Pose pose(particles, p, voxel);
  const Mat3 to_mesh = pose.turn.transpose() * (voxel / particles.scale[p]);
  stamp.distance.assign(stamp.box.count(), static_cast<float>(kBand));
  if (sdf)
    sampled_distances(*sdf, stamp.box, to_mesh, pose.center, pose.scale, needed, stamp.distance);
  else
    exact_distances(shape.mesh, stamp.box, to_mesh, pose.center, pose.scale, needed, stamp.distance);
  // The scan's sign is exact; the sign of an interpolated distance is unreliable very near the surface.
  for (std::size_t at = 0; at < stamp.distance.size(); ++at)
    if (stamp.scan.inside[at]) stamp.distance[at] = -stamp.distance[at];
}

void add_stamps(Slab& slab, const std::vector<Stamp>& stamps, const Particles& particles, const Work& work) {
  work.parallel(slab.z1 - slab.z0, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t plane = begin; plane < end; ++plane)
      for (const Stamp& s : stamps) {
        const bool hole = particles.is_void(s.particle);
        visit_plane(slab, s, plane, [&](std::size_t to, std::size_t from) {
          if (!hole) slab.distance[to] = std::min(slab.distance[to], s.distance[from]);
          const float c = s.scan.coverage[from];
          if (c == 0) return;
          if (hole) {
            slab.holes[to] += c;
          } else {
            share(slab, plane, to, s.particle, c);
          }
          if (s.scan.inside[from] && slab.id[to] < 0) slab.id[to] = s.particle;
        });
      }
  });
}

void add_colors(const Slab& slab, std::size_t k, const Particles& particles, Vec3f* colors) {
  const std::size_t first = slab.index(0, 0, k), count = slab.index(0, 0, 1);
  for (std::size_t i = 0; i < count; ++i) {
    colors[i].setZero();
    if (const std::int32_t p = slab.owner[first + i]; p >= 0)
      colors[i] += slab.coverage[first + i] * particles.color[p];
  }
  for (const Slab::Share& s : slab.shares[k]) colors[s.cell] += s.cover * particles.color[s.particle];
}

}  // namespace terrazzo::voxelize
