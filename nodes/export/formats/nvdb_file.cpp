#include "nodes/export/formats/nvdb_file.h"

#include <fmt/format.h>

#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/io/checked_file.h"

namespace terrazzo::exporting {
namespace {

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

constexpr std::size_t kLongestName = 255;

template <class Grid>
bool add(const openvdb::GridBase& grid, std::vector<Handle>& out) {
  const auto* own = dynamic_cast<const Grid*>(&grid);
  if (own) out.push_back(nanovdb::openToNanoVDB<nanovdb::HostBuffer>(*own));
  return own != nullptr;
}

Handle nano_of(const openvdb::GridBase& grid) {
  if (grid.getName().size() > kLongestName)
    throw Error("bad-names", fmt::format("the name of a grid has {} bytes; a .nvdb file holds {}",
                                         grid.getName().size(), kLongestName));
  std::vector<Handle> out;
  if (!(add<openvdb::FloatGrid>(grid, out) || add<openvdb::DoubleGrid>(grid, out) ||
        add<openvdb::Int32Grid>(grid, out) || add<openvdb::BoolGrid>(grid, out) ||
        add<openvdb::Vec3SGrid>(grid, out) || add<openvdb::Vec3DGrid>(grid, out)))
    throw Error(
        "unsupported-grid",
        fmt::format("a .nvdb file has no type for the grid '{}' of {}", grid.getName(), grid.valueType()),
        "name the other grids with grids")
        .parameter("grids");
  return std::move(out[0]);
}

void write(const std::filesystem::path& path, const std::vector<Handle>& grids) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) { nanovdb::io::writeGrids(out, grids, nanovdb::io::Codec::ZIP); });
}

}  // namespace

Volume fit_for_nvdb(const Volume& volume, std::vector<std::string>& lost) {
  Volume out = volume;
  std::erase_if(out.grids, [&](const auto& grid) {
    const bool fits =
        grid->template isType<openvdb::FloatGrid>() || grid->template isType<openvdb::DoubleGrid>() ||
        grid->template isType<openvdb::Int32Grid>() || grid->template isType<openvdb::BoolGrid>() ||
        grid->template isType<openvdb::Vec3SGrid>() || grid->template isType<openvdb::Vec3DGrid>();
    if (!fits) lost.push_back(grid->getName());
    return !fits;
  });
  return out;
}

void write_nvdb(const std::filesystem::path& path, const Volume& volume, const Work& work) {
  if (volume.grids.empty()) throw Error("no-grids", "the volume has no grids to write");
  initialize_openvdb();
  std::vector<Handle> grids;
  for (const auto& grid : volume.grids) {
    work.check();
    work.done(grids.size(), volume.grids.size());
    grids.push_back(nano_of(*grid));
  }
  write(path, grids);
}

void write_nvdb(const std::filesystem::path& path, const std::string& name, const VoxelBox& box,
                const std::vector<float>& values, const Work& work) {
  initialize_openvdb();
  const auto grid = dense_grid<openvdb::FloatGrid>(name.c_str(), box.size, 1, work,
                                                   [&](std::size_t i) { return values[i]; });
  const Vec3 center = box.corner + box.spacing / 2;
  const auto transform = openvdb::math::Transform::createLinearTransform();
  transform->preScale(openvdb::Vec3d(box.spacing.x(), box.spacing.y(), box.spacing.z()));
  transform->postTranslate(openvdb::Vec3d(center.x(), center.y(), center.z()));
  grid->setTransform(transform);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  std::vector<Handle> grids;
  grids.push_back(nano_of(*grid));
  write(path, grids);
}

}  // namespace terrazzo::exporting
