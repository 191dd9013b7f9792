#include "nodes/volumes/voxelize/voxelize.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
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
  const std::size_t plane = pixels_in(slab.lattice.x(), slab.lattice.y());
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

// If the residual repeats within the box, every particle samples it at a different offset. Otherwise
// particles one period apart would have the same texture. Empty if there are no offsets.
std::vector<Eigen::Vector2i> grain_shifts(const LatticeResidual& grain, const Particles& particles,
                                          const Vec3i& n) {
  std::vector<Eigen::Vector2i> shifts;
  if (grain.periods().maxCoeff() > 1)
    for (std::size_t p = 0; p < particles.count(); ++p) {
      Random random(1, kShiftStream, p);
      const int x = random.below(static_cast<std::uint64_t>(n.x()));
      shifts.emplace_back(x, static_cast<int>(random.below(n.y())));
    }
  return shifts;
}

// The colors of voxels.
struct SlabColoring {
  const Particles& particles;
  double voxel;
  bool has_voids;
  const LatticeResidual& grain;
  const std::vector<Eigen::Vector2i>& shifts;  // of the grain, per particle
  const residual::ResidualField* field;        // or null

  // Colors plane k of the slab. Adds its matter, its voids and their overlap to `sum`, in voxels. `behind`:
  // the binder's detail, or null.
  void color_plane(const Slab& slab, std::size_t k, const BinderDetail* behind, Vec3f* colors,
                   Vec3& sum) const {
    const std::size_t plane = pixels_in(slab.lattice.x(), slab.lattice.y());
    add_colors(slab, k, particles, colors);
    for (std::size_t at = 0; at < plane; ++at) {
      const float c = slab.coverage[k * plane + at];
      const float h = has_voids ? slab.holes[k * plane + at] : 0;
      sum[0] += std::min(c, 1.0f);
      sum[1] += std::min(h, 1.0f);
      sum[2] += std::max(c + h - 1.0f, 0.0f);
      colors[at] = c > 1 ? Vec3f(colors[at] / c) : Vec3f(colors[at] + (1 - c) * particles.binder_color);
    }
    if (field) add_phases(*field, colors, slab, k, voxel, particles.binder_color, behind);
    if (!grain.empty()) add_grain(slab, k, colors);
  }

 private:
  // Adds the residual in sRGB-encoded values, in which it was measured, and clips at 0.
  void add_grain(const Slab& slab, std::size_t k, Vec3f* colors) const {
    const Vec3i& n = slab.lattice;
    const std::size_t plane = pixels_in(n.x(), n.y());
    const Vec3f binder = linear_to_srgb(particles.binder_color);
    for (std::size_t i = 0; i < plane; ++i)
      colors[i] = colors[i] == particles.binder_color ? binder : linear_to_srgb(colors[i]);
    std::vector<Vec3f> offsets(plane, Vec3f::Zero());
    grain.add_plane(slab.z0 + static_cast<int>(k), offsets.data());
    const std::int32_t* ids = &slab.id[k * plane];
    for (int j = 0; j < n.y(); ++j)
      for (int i = 0; i < n.x(); ++i) {
        const std::size_t at = pixel_at(i, j, n.x());
        colors[at] +=
            ids[at] < 0 || shifts.empty() ? offsets[at] : offsets[moved({i, j}, shifts[ids[at]], n)];
        colors[at] = srgb_to_linear(colors[at].cwiseMax(0.0f));
      }
  }
};

openvdb::Vec3s grid_color(const Vec3f& c) { return {c.x(), c.y(), c.z()}; }

// The grids of the volume.
class PackingGrids {
 public:
  PackingGrids(double voxel, const Vec3f& binder_color, bool has_voids)
      : voxel_(voxel), binder_(grid_color(binder_color)), has_voids_(has_voids) {
    density_->setName("density");
    density_->setGridClass(openvdb::GRID_FOG_VOLUME);
    surface_->setName("surface");
    surface_->setGridClass(openvdb::GRID_LEVEL_SET);
    cd_->setName("Cd");
    id_->setName("id");
    holes_->setName("void");
    holes_->setGridClass(openvdb::GRID_FOG_VOLUME);
    const std::initializer_list<openvdb::GridBase*> all = {holes_.get(), density_.get(), surface_.get(),
                                                           cd_.get(), id_.get()};
    for (openvdb::GridBase* g : all) g->setTransform(voxel_transform(voxel));
  }

  // Adds the planes of a slab. `textured`: all colors are active, since the binder's vary too.
  void add(const Slab& slab, const std::vector<Vec3f>& color, bool textured, const Work& work) {
    const int z0 = slab.z0, z1 = slab.z1;
    const openvdb::Coord size(slab.lattice.x(), slab.lattice.y(), slab.lattice.z());
    const auto at = [&](int i, int j, int k) { return slab.index(i, j, k - z0); };
    add_voxels(
        *density_, size, z0, z1,
        [&](int i, int j, int k) { return std::min(slab.coverage[at(i, j, k)], 1.0f); },
        [](float v) { return v > 0; }, work);
    add_voxels(
        *surface_, size, z0, z1,
        [&](int i, int j, int k) { return slab.distance[at(i, j, k)] * static_cast<float>(voxel_); },
        [&](float v) { return std::abs(v) < band_; }, work);
    add_voxels(
        *cd_, size, z0, z1, [&](int i, int j, int k) { return grid_color(color[at(i, j, k)]); },
        [&](const openvdb::Vec3s& v) { return textured || v != binder_; }, work);
    add_voxels(
        *id_, size, z0, z1, [&](int i, int j, int k) { return slab.id[at(i, j, k)]; },
        [](std::int32_t v) { return v >= 0; }, work);
    if (has_voids_)
      add_voxels(
          *holes_, size, z0, z1, [&](int i, int j, int k) { return std::min(slab.holes[at(i, j, k)], 1.0f); },
          [](float v) { return v > 0; }, work);
  }

  Volume volume(const Vec3i& resolution) const {
    Volume out;
    out.resolution = resolution;
    out.grids = {density_, surface_, cd_, id_};
    if (has_voids_) out.grids.push_back(holes_);
    return out;
  }

 private:
  double voxel_;
  float band_ = kBand * voxel_;
  openvdb::Vec3s binder_;
  bool has_voids_;
  openvdb::FloatGrid::Ptr density_ = openvdb::FloatGrid::create(0.0f);
  openvdb::FloatGrid::Ptr surface_ = openvdb::FloatGrid::create(band_);
  openvdb::Vec3SGrid::Ptr cd_ = openvdb::Vec3SGrid::create(binder_);
  openvdb::Int32Grid::Ptr id_ = openvdb::Int32Grid::create(-1);
  openvdb::FloatGrid::Ptr holes_ = openvdb::FloatGrid::create(0.0f);
};

void add_exact_fractions(const Particles& particles, const Shapes& shapes, VoxelReport& report) {
  std::vector<double> mesh_volumes;
  for (const auto& s : shapes.shapes) mesh_volumes.push_back(mesh_volume(s.mesh));
  for (std::size_t p = 0; p < particles.count(); ++p) {
    const double volume = mesh_volumes[particles.shape[p]] * std::pow(particles.scale[p], 3);
    (particles.is_void(p) ? report.exact_void_fraction : report.exact_volume_fraction) +=
        volume / particles.box.prod();
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

  const bool has_voids = particles.void_count() > 0;
  PackingGrids grids(voxel, particles.binder_color, has_voids);
  const auto shifts = grain_shifts(grain, particles, n);
  const SlabColoring coloring{particles, voxel, has_voids, grain, shifts, field ? &*field : nullptr};
  const std::size_t plane = pixels_in(n.x(), n.y());
  const int thickness = std::max<int>(8, static_cast<int>(kSlabVoxels / plane) / 8 * 8);
  std::vector<std::uint8_t> seen(particles.count(), 0);
  Vec3 filled = Vec3::Zero();  // matter, voids, overlap
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
    const auto color_planes = [&](std::size_t begin, std::size_t end) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t k = begin; k < end; ++k)
        coloring.color_plane(slab, k, behind.get(), &color[k * plane], sum);
      return sum;
    };
    filled += slab_work.part(0.82, 0.85)
                  .reduce<Vec3>(z1 - z0, 1, Vec3::Zero(), color_planes,
                                [](const Vec3& a, const Vec3& b) { return Vec3(a + b); });
    for (const std::int32_t p : slab.id)
      if (p >= 0) seen[p] = 1;
    grids.add(slab, color, !grain.empty() || field, slab_work.part(0.85, 1));
  }
  const double voxels = static_cast<double>(plane) * n.z();
  report.volume_fraction = filled[0] / voxels;
  report.void_fraction = filled[1] / voxels;
  report.overlap_fraction = filled[2] / voxels;
  add_exact_fractions(particles, shapes, report);
  report.without_voxel = std::count(seen.begin(), seen.end(), 0);
  return grids.volume(n);
}

}  // namespace terrazzo::voxelize
