// Converts dense planes to OpenVDB trees, leaf by leaf and in parallel.
#pragma once

#include <memory>
#include <vector>

#include "nodes/data/grids.h"
#include "runtime/work.h"

namespace terrazzo::voxelize {

template <class Leaf>
bool uniform_values(const Leaf& leaf, const typename Leaf::ValueType& v) {
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i)
    if (!(leaf.getValue(i) == v)) return false;
  return true;
}

// Adds the voxels [0, size.x) × [0, size.y) × [z0, z1) to `grid`; z0 must be a multiple of 8. value(i, j, k)
// returns a voxel's value, active(v) whether the voxel is active; inactive voxels keep their value too. A
// leaf with one inactive value becomes a tile, or is omitted if that value is the background.
template <class Grid, class Value, class Active>
void add_voxels(Grid& grid, const openvdb::Coord& size, int z0, int z1, Value&& value, Active&& active,
                const Work& work) {
  using Tree = typename Grid::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  constexpr int kEdge = 8;
  static_assert(Leaf::DIM == kEdge);
  const auto background = grid.background();
  const int nx = (size.x() + kEdge - 1) / kEdge, ny = (size.y() + kEdge - 1) / kEdge,
            nz = (z1 - z0 + kEdge - 1) / kEdge;
  std::vector<std::unique_ptr<Leaf>> leaves(static_cast<std::size_t>(nx) * ny * nz);
  work.parallel(leaves.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const openvdb::Coord lo(static_cast<int>(n) % nx * kEdge, static_cast<int>(n) / nx % ny * kEdge,
                              z0 + static_cast<int>(n) / nx / ny * kEdge);
      auto leaf = std::make_unique<Leaf>(lo, background);
      bool plain = true;
      openvdb::Index at = 0;
      for (int i = lo.x(); i < lo.x() + kEdge; ++i)
        for (int j = lo.y(); j < lo.y() + kEdge; ++j)
          for (int k = lo.z(); k < lo.z() + kEdge; ++k, ++at) {
            if (i >= size.x() || j >= size.y() || k >= z1) continue;
            const auto v = value(i, j, k);
            if (active(v)) {
              leaf->setValueOn(at, v);
              plain = false;
            } else {
              leaf->setValueOnly(at, v);
              plain = plain && v == background;
            }
          }
      if (!plain) leaves[n] = std::move(leaf);
    }
  });
  for (auto& leaf : leaves) {
    if (!leaf) continue;
    const auto first = leaf->getFirstValue();
    if (leaf->getValueMask().isOff() && uniform_values(*leaf, first))
      grid.tree().addTile(1, leaf->origin(), first, false);
    else
      grid.tree().addLeaf(leaf.release());
  }
}

}  // namespace terrazzo::voxelize
