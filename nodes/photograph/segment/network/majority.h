// A mode filter of labels.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::segment {

// Gives each pixel the most frequent value of the (2·reach + 1)² pixels around it. Ties keep the pixel's own
// value.
std::vector<std::int32_t> majority(const std::vector<std::int32_t>& labels, int width, int height, int reach,
                                   const Work&);

}  // namespace terrazzo::segment
