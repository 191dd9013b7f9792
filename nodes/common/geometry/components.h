// Connected components of a labeled raster.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"

namespace terrazzo {

struct Components {
  // 0 where the raster is 0, otherwise numbered from 1 by their first pixel in reading order.
  std::vector<std::int32_t> ids;
  std::vector<std::int32_t> values;  // raster value of component k at k − 1
  std::vector<std::int64_t> sizes;   // pixels of component k at k − 1
  int count() const { return count_of(values); }
};

// Connects pixels of the same non-zero value at edges (4 neighbors), with `diagonal` also at corners (8
// neighbors). `raster` holds width × height values in reading order. Two-pass union-find (Rosenfeld and
// Pfaltz 1966).
Components connected_components(const std::vector<std::int32_t>& raster, int width, int height,
                                bool diagonal);

// Renumbers labels from 1 by their first pixel in reading order; 0 stays 0.
void renumber_labels(std::vector<std::int32_t>& labels);

}  // namespace terrazzo
