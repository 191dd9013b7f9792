// Watershed of a relief by flooding.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::segment {

// Labels every pixel with the number (from 1) of the basin that floods it first, with levels rising from 0
// and first come, first served within a level (Meyer 1994; 4-connected; no watershed lines). Basins start at
// the regional minima of `relief`, quantized to 4096 levels between its minimum and maximum.
std::vector<std::int32_t> watershed(const std::vector<float>& relief, int width, int height, const Work&);

// The same from given seeds (0: none), only inside `mask`; unreached pixels stay 0.
std::vector<std::int32_t> watershed(const std::vector<float>& relief, int width, int height,
                                    const std::vector<std::int32_t>& seeds,
                                    const std::vector<std::uint8_t>& mask, const Work&);

}  // namespace terrazzo::segment
