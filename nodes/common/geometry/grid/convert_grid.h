// A grid with the same voxels and values of another type.
#pragma once

#include <memory>

#include "nodes/data/volume.h"

namespace terrazzo {

// A copy with every value, also of tiles, inactive voxels and the background, replaced by convert(value).
// Name, class, transform and metadata stay.
template <class To, class From, class Convert>
std::shared_ptr<To> convert_grid(const From& from, Convert&& convert) {
  using Tree = typename To::TreeType;
  const auto background = convert(from.background());
  auto tree = std::make_shared<Tree>(from.tree(), background, background, openvdb::TopologyCopy());
  auto source = from.cbeginValueAll();
  for (auto it = tree->beginValueAll(); it; ++it, ++source) it.setValue(convert(*source));
  auto to = std::make_shared<To>(static_cast<const openvdb::GridBase&>(from));  // without values
  to->setTree(tree);
  return to;
}

}  // namespace terrazzo
