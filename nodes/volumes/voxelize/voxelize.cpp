#include "nodes/volumes/voxelize/voxelize.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/volume.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/volumes/voxelize/binder_detail.h"
#include "nodes/volumes/voxelize/lattice_residual.h"
#include "nodes/volumes/voxelize/slabs.h"
#include "nodes/volumes/voxelize/sparse.h"
#include "runtime/random.h"

namespace terrazzo::voxelize {
namespace {

constexpr std::size_t kSlabVoxels = std::size_t{1} << 23;  // about 240 MB of dense planes

constexpr std::uint64_t kShiftStream = 0x73686966;

// Index, within a plane, of the cell at `at` + `shift`, wrapped around the box.
std::size_t moved(const Eigen::Vector2i& at, const Eigen::Vector2i& shift, const Vec3i& n) {
  return static_cast<std::size_t>((at.y() + shift.y()) % n.y()) * n.x() + (at.x() + shift.x()) % n.x();
}

// Adds the detail of particles and binder to plane k of the slab, in proportion to their coverage. `kept`:
// the binder's, or null.
void add_phases(const residual::ResidualField& field, Vec3f* colors, const Slab& slab, std::size_t k,
                double voxel, const Vec3f& binder_color, const BinderDetail* kept) {
  const std::size_t plane = static_cast<std::size_t>(slab.lattice.x()) * slab.lattice.y();
  const Vec3f binder = linear_to_srgb(binder_color);
  const Vec3f* behind = kept ? kept->planes[k].data() : nullptr;
  for (std::size_t at = 0; at < plane; ++at) {
    const std::size_t i = k * plane + at;
    const float cover = cover_of(slab, i), depth = std::abs(slab.distance[i]) * static_cast<float>(voxel);
    const Vec3f offset = field.mixed(center_of(slab, at, slab.z0 + static_cast<int>(k), voxel), slab.id[i],
                                     cover, depth, 0, behind);
    if (behind && cover < 1) ++behind;
    const Vec3f flat = colors[at] == binder_color ? binder : linear_to_srgb(colors[at]);
    colors[at] = srgb_to_linear((flat + offset).cwiseMax(0.0f));
  }
}

}  // namespace

Volume voxelize(const Particles& particles, const Shapes& shapes, const Volume* residual,
                const Lattice& lattice, VoxelReport& report, const Work& work, const Detail* detail,
                const Intermediates& intermediates) {
  check(particles, shapes);
  initialize_openvdb();
  const double voxel = lattice.voxel;
  const Vec3i n = lattice.size;
  const LatticeResidual grain =
      residual ? LatticeResidual(*residual, lattice, work.part(0, 0.1)) : LatticeResidual();
  std::optional<residual::ResidualField> field;
  if (detail) field.emplace(*detail, particles, voxel, residual::Keep::Values, work.part(0, 0.1));
  Slabs slabs(particles, shapes, lattice, intermediates, work.part(0.1, 0.3));
  report.detail_periods = grain.periods();
  report.detail_scale = grain.scale();

  using Vec3s = openvdb::Vec3s;
  const auto grid_color = [](const Vec3f& c) { return Vec3s(c.x(), c.y(), c.z()); };
  const float band = kBand * voxel;
  auto density = openvdb::FloatGrid::create(0.0f);
  auto surface = openvdb::FloatGrid::create(band);
  auto cd = openvdb::Vec3SGrid::create(grid_color(particles.binder_color));
  auto id = openvdb::Int32Grid::create(-1);
  density->setName("density"), density->setGridClass(openvdb::GRID_FOG_VOLUME);
  surface->setName("surface"), surface->setGridClass(openvdb::GRID_LEVEL_SET);
  cd->setName("Cd"), id->setName("id");
  auto holes = openvdb::FloatGrid::create(0.0f);
  holes->setName("void"), holes->setGridClass(openvdb::GRID_FOG_VOLUME);
  const bool has_voids = particles.void_count() > 0;
  for (openvdb::GridBase* g :
       {static_cast<openvdb::GridBase*>(holes.get()), static_cast<openvdb::GridBase*>(density.get()),
        static_cast<openvdb::GridBase*>(surface.get()), static_cast<openvdb::GridBase*>(cd.get()),
        static_cast<openvdb::GridBase*>(id.get())})
    g->setTransform(voxel_transform(voxel));

  // If the residual repeats within the box, every particle samples it at a different offset. Otherwise
  // particles one period apart would have the same texture.
  std::vector<Eigen::Vector2i> shifts;
  if (grain.periods().maxCoeff() > 1)
    for (std::size_t p = 0; p < particles.count(); ++p) {
      Random random(1, kShiftStream, p);
      const int x = random.below(static_cast<std::uint64_t>(n.x()));
      shifts.emplace_back(x, static_cast<int>(random.below(n.y())));
    }

  std::vector<double> mesh_volumes, volumes;
  for (const auto& s : shapes.shapes) mesh_volumes.push_back(mesh_volume(s.mesh));
  for (std::size_t p = 0; p < particles.count(); ++p)
    volumes.push_back(mesh_volumes[particles.shape[p]] * std::pow(particles.scale[p], 3));

  const std::size_t plane = static_cast<std::size_t>(n.x()) * n.y();
  const int thickness = std::max<int>(8, static_cast<int>(kSlabVoxels / plane) / 8 * 8);
  std::vector<std::uint8_t> seen(particles.count(), 0);
  double covered = 0, hollow = 0, overlap = 0;
  const openvdb::Coord size(n.x(), n.y(), n.z());
  for (int z0 = 0; z0 < n.z(); z0 += thickness) {
    const int z1 = std::min(n.z(), z0 + thickness);
    const Work slab_work = work.part(0.3 + 0.7 * z0 / n.z(), 0.3 + 0.7 * z1 / n.z());
    const std::shared_ptr<const Slab> geometry = slabs.get(z0, z1, slab_work.part(0, 0.8));
    const Slab& slab = *geometry;
    std::vector<Vec3f> color(slab.coverage.size());
    std::shared_ptr<const BinderDetail> behind;
    if (field && intermediates)
      behind = intermediates.get<BinderDetail>(
          key_of("Voxelize binder of " + slabs.key(z0, z1).text(), *detail),
          [&] { return BinderDetail(*field, slab, voxel, slab_work.part(0.8, 0.82)); });

    const auto sums =
        slab_work.part(0.82, 0.85)
            .reduce<Vec3>(
                z1 - z0, 1, Vec3::Zero(),
                [&](std::size_t begin, std::size_t end) {
                  Vec3 sum = Vec3::Zero();  // matter, voids, overlap
                  for (std::size_t k = begin; k < end; ++k) {
                    add_colors(slab, k, particles, &color[k * plane]);
                    for (std::size_t i = k * plane; i < (k + 1) * plane; ++i) {
                      const float c = slab.coverage[i];
                      const float h = has_voids ? slab.holes[i] : 0;
                      sum[0] += std::min(c, 1.0f);
                      sum[1] += std::min(h, 1.0f);
                      sum[2] += std::max(c + h - 1.0f, 0.0f);
                      color[i] =
                          c > 1 ? Vec3f(color[i] / c) : Vec3f(color[i] + (1 - c) * particles.binder_color);
                    }
                    if (field)
                      add_phases(*field, &color[k * plane], slab, k, voxel, particles.binder_color,
                                 behind.get());
                    if (!grain.empty()) {
                      // Add in sRGB-encoded values, in which the residual was measured, and clip at 0.
                      Vec3f* colors = &color[k * plane];
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
                                            : offsets[moved({i, j}, shifts[ids[at]], n)];
                          colors[at] = srgb_to_linear(colors[at].cwiseMax(0.0f));
                        }
                    }
                  }
                  return sum;
                },
                [](const Vec3& a, const Vec3& b) { return Vec3(a + b); });
    covered += sums[0];
    hollow += sums[1];
    overlap += sums[2];
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
        *cd, size, z0, z1, [&](int i, int j, int k) { return grid_color(color[at(i, j, k)]); },
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
  report.volume_fraction = covered / voxels;
  report.overlap_fraction = overlap / voxels;
  report.void_fraction = hollow / voxels;
  for (std::size_t p = 0; p < volumes.size(); ++p)
    (particles.is_void(p) ? report.exact_void_fraction : report.exact_volume_fraction) +=
        volumes[p] / particles.box.prod();
  report.without_voxel = std::count(seen.begin(), seen.end(), 0);

  Volume out;
  out.resolution = n;
  out.grids = {density, surface, cd, id};
  if (has_voids) out.grids.push_back(holes);
  return out;
}

}  // namespace terrazzo::voxelize
