// Conversion from OpenVDB grids to arrays.
#include <fmt/format.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/render_volume/scan_field.h"
#include "nodes/volumes/render_volume/solid_texture.h"

namespace terrazzo::render_volume {
namespace {

template <class Grid>
std::vector<float> values_of(const Grid& grid, const openvdb::CoordBBox& box, const Work& work) {
  const openvdb::Coord n = box.dim();
  std::vector<float> out(box.volume());
  work.parallel(n.z(), 1, [&](std::size_t begin, std::size_t end) {
    auto accessor = grid.getConstAccessor();
    for (std::size_t z = begin; z < end; ++z)
      for (int y = 0; y < n.y(); ++y)
        for (int x = 0; x < n.x(); ++x)
          out[(z * static_cast<std::size_t>(n.y()) + static_cast<std::size_t>(y)) *
                  static_cast<std::size_t>(n.x()) +
              x] = static_cast<float>(accessor.getValue(box.min().offsetBy(x, y, static_cast<int>(z))));
  });
  return out;
}

bool has_numbers(const openvdb::GridBase& g) {
  return g.isType<openvdb::FloatGrid>() || g.isType<openvdb::DoubleGrid>() || g.isType<openvdb::Int32Grid>();
}

}  // namespace

ScanField scan_field(const Volume& volume, const std::string& name, const Work& work) {
  openvdb::GridBase::ConstPtr grid;
  std::string list;
  for (const auto& g : volume.grids) {
    list += (list.empty() ? "'" : ", '") + g->getName() + "'";
    if (!grid && has_numbers(*g) && (name.empty() || g->getName() == name)) grid = g;
  }
  if (!grid) {
    Error e("no-grid",
            fmt::format("the volume has no grid {}with one number per voxel; it has {}",
                        name.empty() ? "" : "'" + name + "' ", list.empty() ? "none" : list),
            "connect a scan, for example from LoadVolume");
    if (!name.empty()) e.parameter("grid");
    throw e;
  }
  const auto map = grid->transform().baseMap()->getAffineMap();
  const openvdb::Mat4d m = map ? map->getMat4() : openvdb::Mat4d::zero();
  Vec3 spacing;
  for (int i = 0; i < 3; ++i) {
    spacing[i] = m[i][i];
    for (int j = 0; j < 3; ++j)
      if (!(m[i][i] > 0) || (i != j && std::abs(m[i][j]) > 1e-6 * std::abs(m[i][i])))
        throw Error("tilted-volume", "grid '" + grid->getName() + "' is rotated, sheared or mirrored",
                    "resample it to axis-aligned voxels");
  }
  const openvdb::CoordBBox box = voxels_of(volume, *grid);
  if (box.empty())
    throw Error("empty-volume", "grid '" + grid->getName() + "' has no active voxels",
                "connect a grid with active voxels");
  const Vec3i size(box.dim().x(), box.dim().y(), box.dim().z());
  if (size.cast<double>().prod() > 2147483648.0)
    throw Error("too-large",
                fmt::format("grid '{}' is too large: {} × {} × {} voxels", grid->getName(), size.x(),
                            size.y(), size.z()),
                "crop it or reduce its resolution first");
  std::vector<float> values;
  if (grid->isType<openvdb::FloatGrid>())
    values = values_of(static_cast<const openvdb::FloatGrid&>(*grid), box, work);
  else if (grid->isType<openvdb::DoubleGrid>())
    values = values_of(static_cast<const openvdb::DoubleGrid&>(*grid), box, work);
  else
    values = values_of(static_cast<const openvdb::Int32Grid&>(*grid), box, work);
  return scan_field(size, spacing, values, work);
}

SolidTexture SolidTexture::of(const Volume& volume, const Work& work) {
  const auto grid = volume.find<openvdb::Vec3SGrid>("Cd");
  if (!grid)
    throw Error("no-color", "a texture has no color grid `Cd`",
                "connect a solid texture, for example from SolidOptimize");
  const openvdb::CoordBBox box = voxels_of(volume, *grid);
  const double voxels = box.empty() ? 0 : double(box.dim().x()) * box.dim().y() * box.dim().z();
  if (!(voxels >= 1) || voxels > (1 << 30))
    throw Error("empty-volume", "a texture has no voxels, or more than 2^30",
                "connect a solid texture, for example from SolidOptimize");
  const Vec3i size(box.dim().x(), box.dim().y(), box.dim().z());
  std::vector<Vec3f> colors(voxels);
  work.parallel(size.z(), 1, [&](std::size_t begin, std::size_t end) {
    auto accessor = grid->getConstAccessor();
    for (std::size_t z = begin; z < end; ++z)
      for (int y = 0; y < size.y(); ++y)
        for (int x = 0; x < size.x(); ++x) {
          const openvdb::Vec3s v = accessor.getValue(box.min().offsetBy(x, y, static_cast<int>(z)));
          colors[(z * size.y() + y) * size.x() + x] = Vec3f(v[0], v[1], v[2]);
        }
  });
  return SolidTexture(size, static_cast<float>(grid->voxelSize()[0]), colors, work);
}

}  // namespace terrazzo::render_volume
