// Local binary patterns (Ojala, Pietikäinen, Mäenpää 2002), rotation-invariant and uniform, with 8 neighbors.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/compare/texture_observer/crops.h"

namespace terrazzo::texture_observer {

constexpr int kLocalPatterns = 10;

// The code of each pixel, 0 … 9, from lightness on a circle of `radius` pixels: the number of neighbors that
// are at least as light, or 9 if they do not form one arc. Pixels closer than `radius` to the border keep 0.
std::vector<std::uint8_t> local_patterns(const Patch&, int radius);

}  // namespace terrazzo::texture_observer
