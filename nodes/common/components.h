// Connected components of a labelled raster.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace terrazzo {

struct Components {
  std::vector<std::int32_t>
      ids;  // 0 where the raster is 0, else 1…, numbered by their first pixel in reading order
  std::vector<std::int32_t> values;  // raster value of component k at k − 1
  std::vector<std::int64_t> sizes;   // pixels of component k at k − 1
  int count() const { return static_cast<int>(values.size()); }
};

// Pixels of one non-zero value that touch: with `diagonal`, also at a corner (8 neighbours), else at edges
// only (4). `raster` holds width × height values in reading order. Two-pass union–find (Rosenfeld and Pfaltz
// 1966).
Components connected_components(const std::vector<std::int32_t>& raster, int width, int height,
                                bool diagonal);

}  // namespace terrazzo
