// The watershed of the network's maps.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/network/network.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// Labels from 1: the basins of distance × inside × (1 − border / 2) where inside exceeds 0.4. Basins whose
// pass is less than 0.12 below the lower summit are one particle (watershed by dynamics; Grimaud 1992), and
// so are neighbors along whose common border the map of borders stays below 0.3 on average. Basins with a
// summit below 0.2 are no particles. A mode filter of 3 × 3 pixels takes fringes off the outlines.
std::vector<std::int32_t> find_basins(const NetworkMaps&, const Work&);

}  // namespace terrazzo::segment
