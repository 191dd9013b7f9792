#include "nodes/volumes/blocks/block_grids.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/blocks/grid_types.h"

namespace terrazzo::blocks {
namespace {

using openvdb::GridBase;

Box box_of_grid(const Volume& volume, const GridBase& grid, std::size_t block) {
  const auto box = voxels_of(volume, grid);
  if (box.empty() || grid.activeVoxelCount() != box.volume())
    throw Error("not-a-block",
                fmt::format("grid '{}' of block {} does not fill a box: {} voxels have a value",
                            grid.getName(), block, grid.activeVoxelCount()),
                "connect blocks of a solid, such as those of SolidBlock");
  const auto lo = box.min(), size = box.dim();
  return {Vec3i(lo.x(), lo.y(), lo.z()), Vec3i(size.x(), size.y(), size.z())};
}

void check_alike(const GridBase& first, const GridBase& grid, std::size_t block) {
  const auto differs = [&](const char* what) {
    throw Error(
        "unequal-blocks",
        fmt::format("grid '{}' of block {} differs in {} from that of block 0", grid.getName(), block, what),
        "connect blocks of one solid");
  };
  if (grid.type() != first.type()) differs("type");
  if (grid.transform() != first.transform()) differs("transform");
  with_type_of(first, [&]<class Grid>() {
    if (static_cast<const Grid&>(grid).background() != static_cast<const Grid&>(first).background())
      differs("background");
  });
}

}  // namespace

openvdb::GridBase::Ptr empty_like(const GridBase& grid) {
  GridBase::Ptr out;
  with_type_of(grid, [&]<class Grid>() {
    out = Grid::create(static_cast<const Grid&>(grid).background());
    out->insertMeta(grid);
    // Shared, because copying a transform changes its last bits. Grids of values never change.
    out->setTransform(openvdb::ConstPtrCast<openvdb::math::Transform>(grid.constTransformPtr()));
  });
  return out;
}

const Box& BlockGrids::add(const Volume& block) {
  const std::size_t k = boxes_.size();
  const auto& grids = block.grids;
  if (grids.empty()) throw Error("not-a-block", fmt::format("block {} has no grids", k));
  if (count_ > 1 && (block.resolution.array() != 0).any())
    throw Error("not-a-block", fmt::format("block {} is a whole solid that tiles", k),
                "connect blocks of a solid, such as those of SolidBlock");
  if (k == 0)
    for (const auto& grid : grids) first_.grids.push_back(empty_like(*grid));
  const auto& first = first_.grids;
  Box box;
  for (std::size_t g = 0; g < std::max(first.size(), grids.size()); ++g) {
    if (g >= first.size() || g >= grids.size() || first[g]->getName() != grids[g]->getName()) {
      const auto name = [&](const auto& list) { return g < list.size() ? list[g]->getName() : "none"; };
      throw Error("unequal-blocks",
                  fmt::format("grid {} of block {} is '{}', but that of block 0 is '{}'", g, k, name(grids),
                              name(first)),
                  "connect blocks of one solid");
    }
    check_alike(*first[g], *grids[g], k);
    const Box here = box_of_grid(block, *grids[g], k);
    if (g == 0)
      box = here;
    else if (here.low != box.low || here.size != box.size)
      throw Error("not-a-block", fmt::format("the grids '{}' and '{}' of block {} fill different boxes",
                                             grids[0]->getName(), grids[g]->getName(), k));
  }
  return boxes_.emplace_back(box);
}

Box BlockGrids::whole(bool periodic) const {
  const Box box = box_of(boxes_);
  if (periodic && box.low != Vec3i::Zero())
    throw Error("missing-blocks",
                fmt::format("the first block begins at voxel ({}, {}, {}) instead of (0, 0, 0)", box.low.x(),
                            box.low.y(), box.low.z()),
                "connect all blocks of the solid, or set periodic: false")
        .parameter("periodic");
  return box;
}

}  // namespace terrazzo::blocks
