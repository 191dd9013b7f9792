#include "nodes/volumes/join_volumes/join_volumes.h"

#include "nodes/volumes/blocks/block_grids.h"
#include "nodes/volumes/blocks/grid_types.h"

namespace terrazzo::join_volumes {
namespace {

using blocks::with_type_of;

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

Joiner::Joiner(const Volume& first) {
  for (const auto& grid : first.grids) grids_.push_back(blocks::empty_like(*grid));
}

void Joiner::add(const Volume& block) {
  for (std::size_t g = 0; g < grids_.size(); ++g)
    with_type_of(*grids_[g], [&]<class Grid>() {
      copy_voxels(static_cast<const Grid&>(*block.grids[g]), static_cast<Grid&>(*grids_[g]));
    });
}

Volume Joiner::take() {
  Volume out;
  for (auto& grid : grids_) out.grids.push_back(std::move(grid));
  return out;
}

double bytes_of(const Volume& block) {
  double bytes = 0;
  for (const auto& grid : block.grids) bytes += grid->memUsage();
  return bytes;
}

}  // namespace terrazzo::join_volumes
