#include "nodes/join_volumes/join_volumes.h"

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/data/volume.h"

namespace terrazzo::join_volumes {
namespace {

using openvdb::GridBase;

// Calls use.template operator()<Grid>() with the type of the grid.
template <class Use>
void with_type_of(const GridBase& grid, Use&& use) {
  const auto one = [&]<class Grid>() {
    return grid.isType<Grid>() && (use.template operator()<Grid>(), true);
  };
  if (!(one.template operator()<openvdb::FloatGrid>() || one.template operator()<openvdb::Vec3SGrid>() ||
        one.template operator()<openvdb::Int32Grid>() || one.template operator()<openvdb::DoubleGrid>() ||
        one.template operator()<openvdb::BoolGrid>() || one.template operator()<openvdb::Vec3IGrid>()))
    throw Error("unsupported-grid",
                fmt::format("grid '{}' has the unsupported type {}", grid.getName(), grid.type()));
}

Box box_of_grid(const GridBase& grid, std::size_t block) {
  const auto box = grid.evalActiveVoxelBoundingBox();
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

template <class Grid>
void copy_voxels(const Grid& from, Grid& to) {
  using Tree = typename Grid::TreeType;
  auto tile = from.tree().cbeginValueOn();
  tile.setMaxDepth(Tree::ValueOnCIter::LEAF_DEPTH - 1);  // above the leaves: boxes of one value
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    to.tree().sparseFill(box, *tile, true);
  }
  for (auto leaf = from.tree().cbeginLeaf(); leaf; ++leaf) {
    auto* there = to.tree().touchLeaf(leaf->origin());
    for (auto it = leaf->cbeginValueOn(); it; ++it) there->setValueOn(it.pos(), *it);
  }
}

}  // namespace

std::vector<Box> boxes_of(const std::vector<const Volume*>& blocks, const Work& work) {
  std::vector<Box> out;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    work.check();
    const auto &first = blocks[0]->grids, &grids = blocks[k]->grids;
    if (grids.empty()) throw Error("not-a-block", fmt::format("block {} has no grids", k));
    if (blocks.size() > 1 && (blocks[k]->resolution.array() != 0).any())
      throw Error("not-a-block", fmt::format("block {} is a whole solid that tiles", k),
                  "connect blocks of a solid, such as those of SolidBlock");
    for (std::size_t g = 0; g < std::max(first.size(), grids.size()); ++g) {
      if (g >= first.size() || g >= grids.size() || first[g]->getName() != grids[g]->getName()) {
        const auto name = [&](const auto& list) { return g < list.size() ? list[g]->getName() : "none"; };
        throw Error("unequal-blocks",
                    fmt::format("grid {} of block {} is '{}', but that of block 0 is '{}'", g, k, name(grids),
                                name(first)),
                    "connect blocks of one solid");
      }
      check_alike(*first[g], *grids[g], k);
      const Box box = box_of_grid(*grids[g], k);
      if (g == 0)
        out.push_back(box);
      else if (box.low != out.back().low || box.size != out.back().size)
        throw Error("not-a-block", fmt::format("the grids '{}' and '{}' of block {} fill different boxes",
                                               grids[0]->getName(), grids[g]->getName(), k));
    }
  }
  return out;
}

double joined_bytes(const std::vector<const Volume*>& blocks) {
  double bytes = 0;
  for (const Volume* block : blocks)
    for (const auto& grid : block->grids) bytes += static_cast<double>(grid->memUsage());
  return bytes;
}

Volume joined(const std::vector<const Volume*>& blocks, const Work& work) {
  Volume out;
  const std::size_t grids = blocks.at(0)->grids.size();
  for (std::size_t g = 0; g < grids; ++g)
    with_type_of(*blocks[0]->grids[g], [&]<class Grid>() {
      const auto& first = static_cast<const Grid&>(*blocks[0]->grids[g]);
      auto grid = Grid::create(first.background());
      grid->insertMeta(first);
      // Shared, because copying a transform changes its last bits. Grids of values never change.
      grid->setTransform(openvdb::ConstPtrCast<openvdb::math::Transform>(first.constTransformPtr()));
      for (std::size_t k = 0; k < blocks.size(); ++k) {
        work.check();
        copy_voxels(static_cast<const Grid&>(*blocks[k]->grids[g]), *grid);
        work.progress(static_cast<double>(g * blocks.size() + k + 1) /
                      static_cast<double>(grids * blocks.size()));
      }
      out.grids.push_back(std::move(grid));
    });
  return out;
}

}  // namespace terrazzo::join_volumes
