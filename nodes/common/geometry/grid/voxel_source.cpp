#include "nodes/common/geometry/grid/voxel_source.h"

#include <fmt/format.h>

#include <cmath>

#include "nodes/data/volume.h"

namespace terrazzo {
namespace {

template <class Grid>
constexpr bool kIsVector = openvdb::VecTraits<typename Grid::ValueType>::IsVec;

// Calls f with the grid as its own type. Returns false if the type is not one of a volume's.
template <class F>
bool with_grid(const openvdb::GridBase& grid, F&& f) {
  const auto is = [&]<class Grid>(const Grid*) {
    const auto* g = dynamic_cast<const Grid*>(&grid);
    if (g) f(*g);
    return g != nullptr;
  };
  return is(static_cast<const openvdb::FloatGrid*>(nullptr)) ||
         is(static_cast<const openvdb::Int32Grid*>(nullptr)) ||
         is(static_cast<const openvdb::Vec3SGrid*>(nullptr)) ||
         is(static_cast<const openvdb::BoolGrid*>(nullptr)) ||
         is(static_cast<const openvdb::DoubleGrid*>(nullptr)) ||
         is(static_cast<const openvdb::Vec3IGrid*>(nullptr));
}

template <class Grid>
void check_finite(const Grid& grid) {
  using T = typename Grid::ValueType;
  for (auto it = grid.cbeginValueAll(); it; ++it) {
    const T& v = *it;
    bool finite = true;
    if constexpr (kIsVector<Grid>)
      finite = std::isfinite(double(v[0])) && std::isfinite(double(v[1])) && std::isfinite(double(v[2]));
    else
      finite = std::isfinite(double(v));
    if (!finite) {
      const openvdb::Coord at = it.getCoord();
      throw Error("bad-values",
                  fmt::format("grid '{}' is NaN or infinite at voxel ({}, {}, {})", grid.getName(), at[0],
                              at[1], at[2]),
                  "replace those voxels");
    }
  }
}

// The edges of a voxel and the corner of voxel (0, 0, 0), in mm.
std::pair<Vec3, Vec3> lattice_of(const openvdb::GridBase& grid) {
  const auto m = grid.transform().baseMap()->getAffineMap()->getMat4();  // row vectors: p·m
  Vec3 spacing;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double v = m[i][j];
      if (i == j) spacing[i] = v;
      if (i == j ? !(v > 0) || !std::isfinite(v) : v != 0)
        throw Error("tilted-volume",
                    fmt::format("the voxels of grid '{}' are rotated, sheared or mirrored, but must have "
                                "edges along x, y and z",
                                grid.getName()),
                    "resample the volume; only .vdb files hold such grids");
    }
  return {spacing, Vec3(m[3][0], m[3][1], m[3][2]) - 0.5 * spacing};
}

}  // namespace

VoxelBox voxel_box(const Volume& volume) {
  if (volume.grids.empty()) throw Error("no-grids", "the volume has no grids");
  VoxelBox box;
  Vec3 corner;
  std::tie(box.spacing, corner) = lattice_of(*volume.grids[0]);
  for (const auto& g : volume.grids) {
    const auto [spacing, other] = lattice_of(*g);
    if (!spacing.isApprox(box.spacing, 1e-9) || (other - corner).norm() > 1e-6 * spacing.norm())
      throw Error("size-mismatch",
                  fmt::format("the grids '{}' and '{}' have different voxels", volume.grids[0]->getName(),
                              g->getName()),
                  "use grids of equal voxels");
  }
  box.periodic = volume.periodic();
  const openvdb::CoordBBox voxels = voxels_of(volume);
  if (voxels.empty()) throw Error("empty-volume", "the volume has no active voxels");
  for (int k = 0; k < 3; ++k) {
    box.first[k] = voxels.min()[k];
    box.size[k] = voxels.dim()[k];
  }
  box.corner = corner + box.first.cast<double>().cwiseProduct(box.spacing);
  return box;
}

std::vector<std::string> grid_names(const Volume& volume) {
  std::vector<std::string> names;
  for (const auto& g : volume.grids) names.push_back(g->getName());
  return names;
}

VoxelSource::VoxelSource(const Volume& volume, const std::string& grid, const VoxelBox& box)
    : box_(box), name_(grid) {
  for (const auto& g : volume.grids)
    if (g->getName() == grid) grid_ = g;
  if (!grid_)
    throw Error(
        "no-such-grid",
        fmt::format("the volume has no grid '{}' (its grids: {})", grid, fmt::join(grid_names(volume), ", ")),
        "choose one of them");
  const bool known = with_grid(*grid_, [&]<class Grid>(const Grid& g) {
    components_ = kIsVector<Grid> ? 3 : 1;
    whole_ = std::is_same_v<Grid, openvdb::Int32Grid> || std::is_same_v<Grid, openvdb::Vec3IGrid> ||
             std::is_same_v<Grid, openvdb::BoolGrid>;
    yes_no_ = std::is_same_v<Grid, openvdb::BoolGrid>;
    level_set_ = !whole_ && components_ == 1 && g.getGridClass() == openvdb::GRID_LEVEL_SET;
    if (!whole_) check_finite(g);
  });
  if (!known)
    throw Error("unsupported-grid", fmt::format("grid '{}' has the type {}", grid, grid_->type()),
                "use float, double, vec3s, vec3i, int32 or bool");
}

void VoxelSource::read(int z0, int z1, void* out) const {
  with_grid(*grid_, [&]<class Grid>(const Grid& grid) {
    using T = typename Grid::ValueType;
    constexpr bool kWhole =
        std::is_same_v<T, std::int32_t> || std::is_same_v<T, bool> || std::is_same_v<T, openvdb::Vec3i>;
    using Out = std::conditional_t<kWhole, std::int32_t, float>;
    auto* to = static_cast<Out*>(out);
    auto at = grid.getConstAccessor();
    const Vec3i& first = box_.first;
    for (int z = z0; z < z1; ++z)
      for (int y = 0; y < box_.size.y(); ++y)
        for (int x = 0; x < box_.size.x(); ++x) {
          const T& v = at.getValue(openvdb::Coord(first.x() + x, first.y() + y, first.z() + z));
          if constexpr (kIsVector<Grid>)
            for (int k = 0; k < 3; ++k) *to++ = static_cast<Out>(v[k]);
          else
            *to++ = static_cast<Out>(v);
        }
  });
}

}  // namespace terrazzo
