// Plain arrays of voxels as OpenVDB grids.
#pragma once

#include <memory>
#include <vector>

#include "nodes/data/volume.h"
#include "runtime/work.h"

namespace terrazzo {

// A grid whose voxels (0, 0, 0) to size − 1 are all active; value(i) gives number (z·ny + y)·nx + x. Made
// leaf by leaf, so that the array may be freed right after. `voxel` is its edge in mm.
template <class Grid, class Value>
typename Grid::Ptr dense_grid(const char* name, const Vec3i& size, double voxel, const Work& work,
                              Value&& value) {
  using T = typename Grid::ValueType;
  auto grid = Grid::create(openvdb::zeroVal<T>());
  grid->setName(name);
  grid->setTransform(voxel_transform(voxel));
  using Leaf = typename Grid::TreeType::LeafNodeType;
  const Vec3i blocks = (size.array() + 7) / 8;
  std::vector<std::unique_ptr<Leaf>> leaves(static_cast<std::size_t>(blocks.x()) * blocks.y() * blocks.z());
  work.parallel(leaves.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const int b = static_cast<int>(n);
      const openvdb::Coord lo(8 * (b % blocks.x()), 8 * (b / blocks.x() % blocks.y()),
                              8 * (b / blocks.x() / blocks.y()));
      auto leaf = std::make_unique<Leaf>(lo, openvdb::zeroVal<T>());
      openvdb::Index at = 0;
      for (int i = lo.x(); i < lo.x() + 8; ++i)
        for (int j = lo.y(); j < lo.y() + 8; ++j)
          for (int k = lo.z(); k < lo.z() + 8; ++k, ++at)
            if (i < size.x() && j < size.y() && k < size.z())
              leaf->setValueOn(at, value((static_cast<std::size_t>(k) * size.y() + j) * size.x() + i));
      leaves[n] = std::move(leaf);
    }
  });
  for (auto& leaf : leaves) grid->tree().addLeaf(leaf.release());
  return grid;
}

}  // namespace terrazzo
