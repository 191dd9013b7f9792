// OpenVDB grids from plain voxel arrays.
#pragma once

#include <memory>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/volume.h"
#include "runtime/work.h"

namespace terrazzo {

// Creates a grid whose voxels from `origin` to origin + size − 1 are all active. `value(i)` returns voxel
// number (z·ny + y)·nx + x, relative to `origin`. All values are copied, so the array may be freed
// afterwards. `voxel` is the edge length in mm.
template <class Grid, class Value>
typename Grid::Ptr dense_grid(const char* name, const Vec3i& size, double voxel, const Work& work,
                              Value&& value, const Vec3i& origin = Vec3i::Zero()) {
  using T = typename Grid::ValueType;
  auto grid = Grid::create(openvdb::zeroVal<T>());
  grid->setName(name);
  grid->setTransform(voxel_transform(voxel));
  using Leaf = typename Grid::TreeType::LeafNodeType;
  // Leaf origins are multiples of 8.
  const Vec3i first = origin.unaryExpr([](int v) { return v & ~7; }), last = origin + size;
  const Vec3i blocks = (last - first).array().unaryExpr([](int v) { return (v + 7) / 8; });
  std::vector<std::unique_ptr<Leaf>> leaves(voxels_in(blocks));
  work.parallel(leaves.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const int b = n;
      const openvdb::Coord lo(first.x() + 8 * (b % blocks.x()), first.y() + 8 * (b / blocks.x() % blocks.y()),
                              first.z() + 8 * (b / blocks.x() / blocks.y()));
      auto leaf = std::make_unique<Leaf>(lo, openvdb::zeroVal<T>());
      openvdb::Index at = 0;
      for (int i = lo.x(); i < lo.x() + 8; ++i)
        for (int j = lo.y(); j < lo.y() + 8; ++j)
          for (int k = lo.z(); k < lo.z() + 8; ++k, ++at)
            if (i >= origin.x() && j >= origin.y() && k >= origin.z() && i < last.x() && j < last.y() &&
                k < last.z())
              leaf->setValueOn(
                  at,
                  value((static_cast<std::size_t>(k - origin.z()) * size.y() + (j - origin.y())) * size.x() +
                        (i - origin.x())));
      leaves[n] = std::move(leaf);
    }
  });
  for (auto& leaf : leaves) grid->tree().addLeaf(leaf.release());
  return grid;
}

// Gives a dense grid of particle indices the form that Voxelize gives to `id`: inactive where negative, with
// the background −1.
inline void mark_binder(openvdb::Int32Grid& id) {
  id.tree().root().setBackground(-1, /*updateChildNodes=*/false);
  for (auto leaf = id.tree().beginLeaf(); leaf; ++leaf)
    for (auto it = leaf->beginValueOn(); it; ++it)
      if (*it < 0) it.setValueOff();
}

}  // namespace terrazzo
