#include "nodes/voxelize/voxelize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "nodes/common/geometry/mesh.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/volume.h"
#include "nodes/residual/residual_field.h"
#include "nodes/voxelize/lattice_residual.h"
#include "nodes/voxelize/slab.h"
#include "nodes/voxelize/sparse.h"
#include "runtime/random.h"

namespace terrazzo::voxelize {
namespace {

constexpr std::size_t kSlabVoxels = std::size_t{1} << 23;  // about 200 MB of dense planes
constexpr std::size_t kBatchCells = std::size_t{1} << 21;  // stamps held at once

void check(const Particles& particles, const Shapes& shapes) {
  const auto bad = [](std::size_t i, const std::string& what) {
    throw Error("bad-particles", "particle " + std::to_string(i) + " " + what);
  };
  const std::size_t n = particles.count();
  if (particles.shape.size() != n || particles.orientation.size() != n || particles.scale.size() != n ||
      particles.color.size() != n || (!particles.voids.empty() && particles.voids.size() != n))
    throw Error("bad-particles", "the particles' columns differ in length");
  for (std::size_t i = 0; i < n; ++i) {
    if (particles.shape[i] < 0 || particles.shape[i] >= static_cast<std::int32_t>(shapes.shapes.size()))
      bad(i, fmt::format("has shape {}, but there are only {} shapes", particles.shape[i],
                         shapes.shapes.size()));
    if (!particles.position[i].allFinite()) bad(i, "has a position that is NaN or infinite");
    if (!(std::abs(particles.orientation[i].norm() - 1) < 1e-6))
      bad(i, "has an orientation that is not a unit quaternion");
    if (!(particles.scale[i] > 0) || !std::isfinite(particles.scale[i]))
      bad(i, "has a scale that is not positive and finite");
    if (!particles.color[i].allFinite()) bad(i, "has a color that is NaN or infinite");
  }
  if (!particles.binder_color.allFinite())
    throw Error("bad-particles", "the binder color is NaN or infinite");
  for (const auto& s : shapes.shapes) {
    const auto faults = mesh_faults(s.mesh);
    if (!faults.empty())
      throw Error("open-mesh", "shape '" + s.name + "': " + faults.front(),
                  "repair the mesh (LoadMesh.repair)");
  }
}

// Distance lattices by shape and octave of size. The spacing is at most half a voxel for particles up to 32
// voxels long and at most one voxel up to 256; longer ones use 256 cells. A lattice that few particles would
// share takes longer to make than their distances.
class Sdfs {
 public:
  Sdfs(const Particles& particles, const Shapes& shapes, double voxel, const Work& work) {
    std::vector<double> extent;
    for (const auto& s : shapes.shapes) {
      Eigen::AlignedBox3d box;
      for (const auto& v : s.mesh.vertices) box.extend(v);
      extent.push_back(box.sizes().maxCoeff());
    }
    for (std::size_t p = 0; p < particles.count(); ++p) {
      const double voxels = extent[particles.shape[p]] * particles.scale[p] / voxel;
      const double wanted = voxels <= 32 ? 2 * voxels : voxels;
      int cells = 4;
      while (cells < wanted && cells < 256) cells *= 2;
      key_.emplace_back(particles.shape[p], cells);
      double& band = band_[key_.back()];
      // The level set's band plus a margin for interpolation, limited for particles smaller than a voxel.
      band = std::max(band, std::min((kBand + 0.1) * cells / voxels + 1.8, 8.0 * kBand));
    }
    constexpr int kFew = 4;
    std::map<Key, int> uses;
    for (const Key& key : key_) ++uses[key];
    std::erase_if(band_, [&](const auto& entry) { return uses[entry.first] <= kFew; });
    double done = 0;
    for (const auto& [key, band] : band_) {
      const double next = done + 1.0 / static_cast<double>(band_.size());
      sdfs_.emplace(key, MeshSdf(shapes.shapes[key.first].mesh, key.second, band, work.part(done, next)));
      done = next;
    }
  }
  // Null if the particle's distances are to be computed from its mesh.
  const MeshSdf* of(std::size_t particle) const {
    const auto it = sdfs_.find(key_[particle]);
    return it == sdfs_.end() ? nullptr : &it->second;
  }

 private:
  using Key = std::pair<std::int32_t, int>;
  std::vector<Key> key_;
  std::map<Key, double> band_;
  std::map<Key, MeshSdf> sdfs_;
};

// The lattice cells that a particle's level set can reach.
CellBox reach(const Particles& particles, const Shape& shape, std::size_t p, double voxel) {
  const Mat3 turn = particles.orientation[p].toRotationMatrix() * (particles.scale[p] / voxel);
  Eigen::AlignedBox3d box;
  for (const auto& v : shape.mesh.vertices) box.extend(turn * v);
  const Vec3 center = particles.position[p] / voxel - Vec3::Constant(0.5);
  CellBox out;
  out.lo = (center + box.min()).array().floor().cast<int>() - static_cast<int>(kBand);
  out.size = (center + box.max()).array().ceil().cast<int>() + static_cast<int>(kBand) + 1 - out.lo.array();
  return out;
}

// Stamps for the planes of the slab: one per period in which a particle meets them.
std::vector<Stamp> stamps_of(const std::vector<CellBox>& boxes, int z0, int z1, int nz) {
  std::vector<Stamp> all;
  for (std::size_t p = 0; p < boxes.size(); ++p) {
    const int lo = boxes[p].lo.z(), hi = lo + boxes[p].size.z();
    for (int period = static_cast<int>(std::floor(double(lo - z1) / nz)); z0 + period * nz < hi; ++period) {
      const int a = std::max(lo, z0 + period * nz), b = std::min(hi, z1 + period * nz);
      if (a >= b) continue;
      Stamp s;
      s.particle = static_cast<std::int32_t>(p), s.box = boxes[p];
      s.box.lo.z() = a, s.box.size.z() = b - a;
      all.push_back(std::move(s));
    }
  }
  return all;
}

void fill_slab(Slab& slab, std::vector<Stamp> stamps, const Particles& particles, const Shapes& shapes,
               const Sdfs& sdfs, double voxel, const Work& work) {
  for (std::size_t begin = 0; begin < stamps.size();) {
    std::size_t end = begin, cells = 0;
    while (end < stamps.size() && (end == begin || cells + stamps[end].box.count() <= kBatchCells))
      cells += stamps[end++].box.count();
    std::vector<Stamp> batch(std::make_move_iterator(stamps.begin() + begin),
                             std::make_move_iterator(stamps.begin() + end));
    const Work part = work.part(double(begin) / stamps.size(), double(end) / stamps.size());
    part.part(0, 0.8).parallel(batch.size(), 4, [&](std::size_t b, std::size_t e) {
      for (std::size_t i = b; i < e; ++i) {
        const std::size_t p = batch[i].particle;
        make_stamp(batch[i], particles, shapes.shapes[particles.shape[p]], sdfs.of(p), voxel);
      }
    });
    add_stamps(slab, batch, particles, part.part(0.8, 1));
    begin = end;
  }
}

constexpr std::uint64_t kShiftStream = 0x73686966;

// Index, within a plane, of the cell at `at` + `shift`, wrapped around the box.
std::size_t moved(const Eigen::Vector2i& at, const Eigen::Vector2i& shift, const Vec3i& n) {
  return static_cast<std::size_t>((at.y() + shift.y()) % n.y()) * n.x() + (at.x() + shift.x()) % n.x();
}

// Adds the detail of particles and binder to plane k of the slab, in proportion to their coverage.
void add_phases(const residual::ResidualField& field, Vec3f* colors, const Slab& slab, std::size_t k, int z0,
                double voxel, const Vec3f& binder_color) {
  const Vec3i& n = slab.lattice;
  const std::size_t plane = static_cast<std::size_t>(n.x()) * n.y();
  const Vec3f binder = linear_to_srgb(binder_color);
  for (int j = 0; j < n.y(); ++j)
    for (int i = 0; i < n.x(); ++i) {
      const std::size_t at = static_cast<std::size_t>(j) * n.x() + i;
      const Vec3f mm =
          ((Vec3(i, j, z0 + static_cast<double>(k)).array() + 0.5) * voxel).matrix().cast<float>();
      const std::int32_t id = slab.id[k * plane + at];
      const float depth = std::abs(slab.distance[k * plane + at]) * static_cast<float>(voxel);
      const Vec3f offset = field.mixed(mm, id, std::min(slab.coverage[k * plane + at], 1.0f), depth);
      const Vec3f flat = colors[at] == binder_color ? binder : linear_to_srgb(colors[at]);
      colors[at] = srgb_to_linear((flat + offset).cwiseMax(0.0f));
    }
}

}  // namespace

Volume voxelize(const Particles& particles, const Shapes& shapes, const Volume* residual,
                const Lattice& lattice, VoxelReport& report, const Work& work, const Detail* detail) {
  check(particles, shapes);
  initialize_openvdb();
  const double voxel = lattice.voxel;
  const Vec3i n = lattice.size;
  const LatticeResidual grain =
      residual ? LatticeResidual(*residual, lattice, work.part(0, 0.1)) : LatticeResidual();
  std::optional<residual::ResidualField> field;
  if (detail) field.emplace(*detail, particles, voxel, residual::Keep::Values, work.part(0, 0.1));
  const Sdfs sdfs(particles, shapes, voxel, work.part(0.1, 0.3));
  report.detail_periods = grain.periods(), report.detail_scale = grain.scale();

  using Vec3s = openvdb::Vec3s;
  const auto grid_color = [](const Vec3f& c) { return Vec3s(c.x(), c.y(), c.z()); };
  const float band = static_cast<float>(kBand * voxel);
  auto density = openvdb::FloatGrid::create(0.0f);
  auto surface = openvdb::FloatGrid::create(band);
  auto color = openvdb::Vec3SGrid::create(grid_color(particles.binder_color));
  auto id = openvdb::Int32Grid::create(-1);
  density->setName("density"), density->setGridClass(openvdb::GRID_FOG_VOLUME);
  surface->setName("surface"), surface->setGridClass(openvdb::GRID_LEVEL_SET);
  color->setName("Cd"), id->setName("id");
  auto holes = openvdb::FloatGrid::create(0.0f);
  holes->setName("void"), holes->setGridClass(openvdb::GRID_FOG_VOLUME);
  const bool has_voids = particles.void_count() > 0;
  for (openvdb::GridBase* g :
       {static_cast<openvdb::GridBase*>(holes.get()), static_cast<openvdb::GridBase*>(density.get()),
        static_cast<openvdb::GridBase*>(surface.get()), static_cast<openvdb::GridBase*>(color.get()),
        static_cast<openvdb::GridBase*>(id.get())})
    g->setTransform(voxel_transform(voxel));

  // If the residual repeats within the box, every particle samples it at a different offset. Otherwise
  // particles one period apart would have the same texture.
  std::vector<Eigen::Vector2i> shifts;
  if (grain.periods().maxCoeff() > 1)
    for (std::size_t p = 0; p < particles.count(); ++p) {
      Random random(1, kShiftStream, p);
      const int x = static_cast<int>(random.below(static_cast<std::uint64_t>(n.x())));
      shifts.emplace_back(x, static_cast<int>(random.below(static_cast<std::uint64_t>(n.y()))));
    }

  std::vector<double> mesh_volumes, volumes;
  for (const auto& s : shapes.shapes) mesh_volumes.push_back(mesh_volume(s.mesh));
  for (std::size_t p = 0; p < particles.count(); ++p)
    volumes.push_back(mesh_volumes[particles.shape[p]] * std::pow(particles.scale[p], 3));
  std::vector<CellBox> boxes;
  for (std::size_t p = 0; p < particles.count(); ++p)
    boxes.push_back(reach(particles, shapes.shapes[particles.shape[p]], p, voxel));

  const std::size_t plane = static_cast<std::size_t>(n.x()) * n.y();
  const int thickness = std::max<int>(8, static_cast<int>(kSlabVoxels / plane) / 8 * 8);
  std::vector<std::uint8_t> seen(particles.count(), 0);
  double covered = 0, hollow = 0, overlap = 0;
  const openvdb::Coord size(n.x(), n.y(), n.z());
  for (int z0 = 0; z0 < n.z(); z0 += thickness) {
    const int z1 = std::min(n.z(), z0 + thickness);
    const Work slab_work = work.part(0.3 + 0.7 * z0 / n.z(), 0.3 + 0.7 * z1 / n.z());
    Slab slab(n, z0, z1, has_voids);
    fill_slab(slab, stamps_of(boxes, z0, z1, n.z()), particles, shapes, sdfs, voxel, slab_work.part(0, 0.8));

    const auto sums = slab_work.part(0.8, 0.85).reduce<Vec3>(
        z1 - z0, 1, Vec3::Zero(),
        [&](std::size_t begin, std::size_t end) {
          Vec3 sum = Vec3::Zero();  // matter, voids, overlap
          for (std::size_t k = begin; k < end; ++k) {
            for (std::size_t i = k * plane; i < (k + 1) * plane; ++i) {
              const float c = slab.coverage[i];
              const float h = has_voids ? slab.holes[i] : 0;
              sum[0] += std::min(c, 1.0f), sum[1] += std::min(h, 1.0f),
                  sum[2] += std::max(c + h - 1.0f, 0.0f);
              slab.color[i] =
                  c > 1 ? Vec3f(slab.color[i] / c) : Vec3f(slab.color[i] + (1 - c) * particles.binder_color);
            }
            if (field) add_phases(*field, &slab.color[k * plane], slab, k, z0, voxel, particles.binder_color);
            if (!grain.empty()) {
              // Add in sRGB-encoded values, in which the residual was measured, and clip at 0.
              Vec3f* colors = &slab.color[k * plane];
              const Vec3f binder = linear_to_srgb(particles.binder_color);
              for (std::size_t i = 0; i < plane; ++i)
                colors[i] = colors[i] == particles.binder_color ? binder : linear_to_srgb(colors[i]);
              std::vector<Vec3f> offsets(plane, Vec3f::Zero());
              grain.add_plane(z0 + static_cast<int>(k), offsets.data());
              const std::int32_t* ids = &slab.id[k * plane];
              for (int j = 0; j < n.y(); ++j)
                for (int i = 0; i < n.x(); ++i) {
                  const std::size_t at = static_cast<std::size_t>(j) * n.x() + i;
                  colors[at] += ids[at] < 0 || shifts.empty()
                                    ? offsets[at]
                                    : offsets[moved({i, j}, shifts[static_cast<std::size_t>(ids[at])], n)];
                  colors[at] = srgb_to_linear(colors[at].cwiseMax(0.0f));
                }
            }
          }
          return sum;
        },
        [](const Vec3& a, const Vec3& b) { return Vec3(a + b); });
    covered += sums[0], hollow += sums[1], overlap += sums[2];
    for (const std::int32_t p : slab.id)
      if (p >= 0) seen[p] = 1;

    const Work grids = slab_work.part(0.85, 1);
    const auto at = [&](int i, int j, int k) { return slab.index(i, j, k - z0); };
    add_voxels(
        *density, size, z0, z1,
        [&](int i, int j, int k) { return std::min(slab.coverage[at(i, j, k)], 1.0f); },
        [](float v) { return v > 0; }, grids);
    add_voxels(
        *surface, size, z0, z1,
        [&](int i, int j, int k) { return slab.distance[at(i, j, k)] * static_cast<float>(voxel); },
        [&](float v) { return std::abs(v) < band; }, grids);
    const Vec3s binder = grid_color(particles.binder_color);
    const bool dense = !grain.empty() || field;
    add_voxels(
        *color, size, z0, z1, [&](int i, int j, int k) { return grid_color(slab.color[at(i, j, k)]); },
        [&](const Vec3s& v) { return dense || v != binder; }, grids);
    add_voxels(
        *id, size, z0, z1, [&](int i, int j, int k) { return slab.id[at(i, j, k)]; },
        [](std::int32_t v) { return v >= 0; }, grids);
    if (has_voids)
      add_voxels(
          *holes, size, z0, z1, [&](int i, int j, int k) { return std::min(slab.holes[at(i, j, k)], 1.0f); },
          [](float v) { return v > 0; }, grids);
  }
  const double voxels = static_cast<double>(plane) * n.z();
  report.volume_fraction = covered / voxels, report.overlap_fraction = overlap / voxels;
  report.void_fraction = hollow / voxels;
  for (std::size_t p = 0; p < volumes.size(); ++p)
    (particles.is_void(p) ? report.exact_void_fraction : report.exact_volume_fraction) +=
        volumes[p] / particles.box.prod();
  report.without_voxel = static_cast<std::size_t>(std::count(seen.begin(), seen.end(), 0));

  Volume out;
  out.resolution = n;
  out.grids = {density, surface, color, id};
  if (has_voids) out.grids.push_back(holes);
  return out;
}

}  // namespace terrazzo::voxelize
