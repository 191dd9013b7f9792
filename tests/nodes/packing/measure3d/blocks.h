// Volumes of labels made from a formula.
#pragma once

#include <algorithm>
#include <functional>
#include <string>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/packing/measure3d/minkowski.h"
#include "nodes/packing/measure3d/raster.h"
#include "runtime/random.h"

namespace terrazzo::test {

inline constexpr std::uint64_t kPlenty = 1ull << 32;  // bytes of memory

using LabelAt = std::function<std::int32_t(int x, int y, int z)>;

inline Volume label_volume(const Vec3i& size, double spacing, bool periodic, const LabelAt& label) {
  Volume v;
  const auto nx = static_cast<std::size_t>(size.x()), ny = static_cast<std::size_t>(size.y());
  add_id_grid(v, "id", size, Vec3::Constant(spacing), {}, [&](std::size_t i) {
    return label(static_cast<int>(i % nx), static_cast<int>(i / nx % ny), static_cast<int>(i / nx / ny));
  });
  if (periodic) v.resolution = size;
  return v;
}

// The raster that Measure3D makes of labels; `phase` is that of labels ≥ 0.
inline measure3d::Raster raster_of(const Vec3i& size, const Vec3& spacing, bool periodic,
                                   const LabelAt& label) {
  measure3d::Raster r;
  r.box.size = size;
  r.box.spacing = spacing;
  r.box.periodic = periodic;
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        r.ids.push_back(label(x, y, z));
        r.in.push_back(r.ids.back() >= 0);
        r.inside += r.in.back();
      }
  return r;
}

// Of labels 0, 1, …, all of which are wanted.
inline measure3d::Classes classes_of(const Vec3i& size, const Vec3& spacing, bool periodic,
                                     const LabelAt& label) {
  measure3d::Classes c;
  c.box = raster_of(size, spacing, periodic, label).box;
  for (const std::int32_t id : raster_of(size, spacing, periodic, label).ids) {
    const auto k = static_cast<std::size_t>(id);
    while (c.count() <= k) {
      c.name.push_back(std::to_string(c.count()));
      c.voxels.push_back(0);
      c.faces_only.push_back(0);
      c.wanted.push_back(1);
    }
    c.of.push_back(static_cast<std::uint8_t>(id));
    ++c.voxels[k];
  }
  return c;
}

// Random labels 0 to count − 1: of single voxels, or of cubes of `edge` voxels that lie beside the voxels'
// own coordinates.
inline LabelAt random_labels(int count, int edge, std::uint64_t seed) {
  return [=](int x, int y, int z) {
    const auto at = static_cast<std::uint64_t>(((z + 1) / edge * 64 + (y + 1) / edge) * 64 + (x + 1) / edge);
    return std::min(count - 1, static_cast<std::int32_t>(Random(seed, 5, at).uniform() * count));
  };
}

// The densities of the phase of a raster.
inline measure3d::MinkowskiDensities densities_of(const measure3d::Raster& raster,
                                                  measure3d::Phase phase = measure3d::Phase::Particles) {
  const auto classes = measure3d::classes_of_phase(raster, phase);
  return measure3d::minkowski_densities(measure3d::count_cubes(classes, {})[1], raster.box.spacing,
                                        classes.faces_only[1]);
}

// The area between the phase and the rest, mm².
inline double surface_of(const measure3d::Raster& raster) {
  return densities_of(raster).surface * static_cast<double>(raster.count()) * raster.voxel_volume();
}

// A Boolean model: overlapping balls of `radius` voxels at `count` random points of a periodic cube of n
// voxels. The label is −1 in the pores, else 0.
inline measure3d::Raster boolean_model(int n, double radius, int count, std::uint64_t seed) {
  std::vector<Vec3> center;
  for (int k = 0; k < count; ++k) {
    Random r(seed, 3, static_cast<std::uint64_t>(k));
    const double x = r.uniform(0, n), y = r.uniform(0, n), z = r.uniform(0, n);
    center.emplace_back(x, y, z);
  }
  std::vector<char> inside(static_cast<std::size_t>(n) * n * n, 0);
  const int reach = static_cast<int>(radius) + 1;
  for (const Vec3& c : center)
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const Vec3i v = c.array().floor().cast<int>().matrix() + Vec3i(x, y, z);
          if ((v.cast<double>() + Vec3::Constant(0.5) - c).norm() > radius) continue;
          inside[(static_cast<std::size_t>(wrap_index(v.z(), n)) * n + wrap_index(v.y(), n)) * n +
                 wrap_index(v.x(), n)] = 1;
        }
  return raster_of(Vec3i::Constant(n), Vec3::Ones(), true, [&](int x, int y, int z) {
    return inside[(static_cast<std::size_t>(z) * n + y) * n + x] ? 0 : -1;
  });
}

}  // namespace terrazzo::test
