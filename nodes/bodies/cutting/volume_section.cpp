#include "nodes/bodies/cutting/volume_section.h"

#include <fmt/format.h>
#include <openvdb/tools/Count.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>

#include "nodes/bodies/cutting/pixel_regions.h"
#include "nodes/data/indices.h"
#include "nodes/data/volume.h"

namespace terrazzo::section {

namespace {

// Samples a grid at points in space. Periodic volumes repeat.
template <class Grid>
class Sampler {
 public:
  using T = typename Grid::ValueType;
  Sampler(const Grid& grid, const Volume& volume)
      : grid_(grid), accessor_(grid.getConstAccessor()), n_(volume.resolution) {}

  T trilinear(const Vec3& world) const {
    int base[3];
    double t[3];
    locate(world, base, t);
    T sum = openvdb::zeroVal<T>();
    for (int c = 0; c < 8; ++c)
      if (const double w = weight(c, t); w > 0)
        sum = sum +
              T(read(base[0] + (c & 1), base[1] + (c >> 1 & 1), base[2] + (c >> 2)) * static_cast<float>(w));
    return sum;
  }

  // The most frequent value among the eight surrounding voxels, weighted trilinearly. On oblique planes this
  // gives smooth region edges, where the nearest voxel would give steps and specks. Ties go to the nearest
  // voxel's value.
  T majority(const Vec3& world) const {
    int base[3];
    double t[3];
    locate(world, base, t);
    T value[8];
    double votes[8] = {};
    int n = 0;
    for (int c = 0; c < 8; ++c) {
      const T v = read(base[0] + (c & 1), base[1] + (c >> 1 & 1), base[2] + (c >> 2));
      const int at = std::find(value, value + n, v) - value;
      if (at == n) value[n++] = v;
      votes[at] += weight(c, t);
    }
    const T nearest = read(base[0] + (t[0] >= 0.5), base[1] + (t[1] >= 0.5), base[2] + (t[2] >= 0.5));
    int best = std::find(value, value + n, nearest) - value;
    for (int k = 0; k < n; ++k)
      if (votes[k] > votes[best] + 1e-9) best = k;
    return value[best];
  }

 private:
  void locate(const Vec3& world, int* base, double* t) const {
    const openvdb::Vec3d at = grid_.worldToIndex(openvdb::Vec3d(world.x(), world.y(), world.z()));
    for (int k = 0; k < 3; ++k) {
      // Snap to voxel centers, so that rounding does not blend in a neighbor.
      const double whole = std::round(at[k]), v = std::abs(at[k] - whole) < 1e-6 ? whole : at[k];
      base[k] = round_down(v);
      t[k] = v - base[k];
    }
  }
  static double weight(int corner, const double* t) {
    double w = 1;
    for (int k = 0; k < 3; ++k) w *= corner >> k & 1 ? t[k] : 1 - t[k];
    return w;
  }
  T read(int x, int y, int z) const {
    int v[3] = {x, y, z};
    for (int k = 0; k < 3; ++k)
      if (n_[k] > 0) v[k] = (v[k] % n_[k] + n_[k]) % n_[k];
    return accessor_.getValue(openvdb::Coord(v[0], v[1], v[2]));
  }
  const Grid& grid_;
  typename Grid::ConstAccessor accessor_;
  Vec3i n_;
};

Vec3f vector_of(const openvdb::Vec3s& v) { return {v[0], v[1], v[2]}; }
Vec3f vector_of(float v) { return {v, v, v}; }

constexpr std::int32_t kMostPhases = 255;

// The highest phase in a volume. Throws Error "too-many-phases".
std::int32_t highest_phase(const openvdb::Int32Grid& grid) {
  const std::int32_t out = openvdb::tools::minMax(grid.tree()).max();
  if (out > kMostPhases)
    throw Error("too-many-phases",
                fmt::format("the grid phase holds numbers up to {}, at most {} are phases", out, kMostPhases),
                "number the phases from 0");
  return out;
}

// Calls sample(sampler, point, x, row, section) at every pixel center.
template <class Grid, class Sample>
void sweep(const Grid& grid, const Volume& volume, const SectionLayout& layout, const Vec3& corner,
           const Work& work, Sample sample) {
  const double mm_x = layout.width / layout.pixels_x, mm_y = layout.height / layout.pixels_y;
  work.parallel(layout.planes.size() * layout.pixels_y, 16, [&](std::size_t begin, std::size_t end) {
    const Sampler<Grid> sampler(grid, volume);
    for (std::size_t i = begin; i < end; ++i) {
      const int section = i / layout.pixels_y, row = i % layout.pixels_y;
      const SectionPlane& plane = layout.planes[section];
      const Vec3 start = corner + plane.origin + plane.frame.col(1) * ((layout.pixels_y - row - 0.5) * mm_y);
      for (int x = 0; x < layout.pixels_x; ++x)
        sample(sampler, start + plane.frame.col(0) * ((x + 0.5) * mm_x), x, row, section);
    }
  });
}

}  // namespace

VolumeBox volume_box(const Volume& volume) {
  if (volume.grids.empty()) throw Error("no-grids", "the volume has no grids");
  const auto& transform = volume.grids[0]->transform();
  const openvdb::Vec3d voxel = transform.voxelSize();
  VolumeBox box;
  box.voxel = std::min({voxel[0], voxel[1], voxel[2]});
  box.periodic = volume.periodic();
  const openvdb::CoordBBox voxels = voxels_of(volume);
  if (voxels.empty()) throw Error("empty-volume", "the volume has no active voxels");
  const openvdb::Vec3d lo = transform.indexToWorld(voxels.min().asVec3d() - openvdb::Vec3d(0.5));
  const openvdb::Vec3d hi = transform.indexToWorld(voxels.max().asVec3d() + openvdb::Vec3d(0.5));
  for (int k = 0; k < 3; ++k) {
    box.corner[k] = std::min(lo[k], hi[k]);
    box.size[k] = std::abs(hi[k] - lo[k]);
  }
  if (!(box.size.minCoeff() > 0)) throw Error("empty-volume", "the volume's box has no extent");
  return box;
}

VolumeSection cut_volume(const Volume& volume, const SectionLayout& layout, const Work& work) {
  const VolumeBox box = volume_box(volume);
  const auto color = volume.find<openvdb::Vec3SGrid>("Cd");
  const auto density = volume.find<openvdb::FloatGrid>("density");
  const auto id = volume.find<openvdb::Int32Grid>("id");
  const auto phase = id ? nullptr : volume.find<openvdb::Int32Grid>("phase");
  if (!color && !density && !phase)
    throw Error(
        "no-color",
        "the volume has neither a grid Cd (vectors) nor a grid density (floats) nor a grid phase (whole "
        "numbers)",
        "rename one of its grids to Cd, density or phase");

  const std::int32_t last_phase = phase ? highest_phase(*phase) : 0;
  VolumeSection out;
  out.color_grid = color ? "Cd" : density ? "density" : "phase";
  out.label_grid = id ? "id" : phase ? "phase" : density ? "density" : "";
  const int sections = layout.planes.size();
  out.image = Image(layout.pixels_x, layout.pixels_y, sections, layout.pixel_size);
  auto shade = [&](const auto& sampler, const Vec3& p, int x, int row, int section) {
    out.image.at(x, row, section) = vector_of(sampler.trilinear(p));
  };
  if (color)
    sweep(*color, volume, layout, box.corner, work.part(0, 0.5), shade);
  else if (density)
    sweep(*density, volume, layout, box.corner, work.part(0, 0.5), shade);
  else
    sweep(
        *phase, volume, layout, box.corner, work.part(0, 0.5),
        [&, most = std::max(1, last_phase)](const auto& sampler, const Vec3& p, int x, int row, int section) {
          out.image.at(x, row, section) =
              vector_of(static_cast<float>(std::max(0, sampler.majority(p))) / static_cast<float>(most));
        });

  // −1: binder. Without ids all particles have the same value and are separated only by connectivity.
  PixelRegions pixels(layout, out.image);
  if (id || phase)
    sweep(id ? *id : *phase, volume, layout, box.corner, work.part(0.5, 0.9),
          [&](const auto& sampler, const Vec3& p, int x, int row, int section) {
            pixels.value(x, row, section) =
                id ? std::max(-1, sampler.majority(p)) : std::max(0, sampler.majority(p)) - 1;
          });
  else if (density)
    sweep(*density, volume, layout, box.corner, work.part(0.5, 0.9),
          [&](const auto& sampler, const Vec3& p, int x, int row, int section) {
            pixels.value(x, row, section) = sampler.trilinear(p) >= 0.5f ? 0 : -1;
          });
  pixels.measure(out, phase != nullptr, work);
  return out;
}

}  // namespace terrazzo::section
