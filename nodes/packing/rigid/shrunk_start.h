// Recognizes a packing whose particles were shrunk by one factor, as an interrupted packing is, so that it
// can go on.
#pragma once

#include <optional>

#include "nodes/packing/rigid/population/population.h"

namespace terrazzo::packing {

// If `start` consists of at least half of the particles of `fresh` (made without a start), in their order and
// in the same box, all scaled by one factor below 1: `fresh` with these particles first, at the positions of
// `start`, with their full size; `start_shrink` is the factor. Otherwise nothing.
std::optional<Population> regrown(Population fresh, const Particles& start);

}  // namespace terrazzo::packing
