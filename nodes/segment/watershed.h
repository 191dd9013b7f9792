// Watersheds of a relief by flooding.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo {

// Every pixel gets the number (1…) of the basin that floods it first; levels rise from 0, within a level
// first come, first served (Meyer 1994; 4 neighbours; no watershed lines). Basins start at the regional
// minima of `relief`, quantised to 4096 levels between its least and its largest value.
std::vector<std::int32_t> watershed(const std::vector<float>& relief, int width, int height, const Work&);

// The same from given seeds (0 where none), inside `mask` only; unreached pixels stay 0.
std::vector<std::int32_t> watershed(const std::vector<float>& relief, int width, int height,
                                    const std::vector<std::int32_t>& seeds,
                                    const std::vector<std::uint8_t>& mask, const Work&);

}  // namespace terrazzo
