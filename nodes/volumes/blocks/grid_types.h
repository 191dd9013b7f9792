// The types of grids that blocks may have.
#pragma once

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/data/volume.h"

namespace terrazzo::blocks {

// Calls use.template operator()<Grid>() with the type of the grid. Throws Error "unsupported-grid".
template <class Use>
void with_type_of(const openvdb::GridBase& grid, Use&& use) {
  const auto one = [&]<class Grid>() {
    return grid.isType<Grid>() && (use.template operator()<Grid>(), true);
  };
  if (!(one.template operator()<openvdb::FloatGrid>() || one.template operator()<openvdb::Vec3SGrid>() ||
        one.template operator()<openvdb::Int32Grid>() || one.template operator()<openvdb::DoubleGrid>() ||
        one.template operator()<openvdb::BoolGrid>() || one.template operator()<openvdb::Vec3IGrid>()))
    throw Error("unsupported-grid",
                fmt::format("grid '{}' has the unsupported type {}", grid.getName(), grid.type()));
}

}  // namespace terrazzo::blocks
