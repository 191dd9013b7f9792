// Touching particles told apart by colour.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/segment/regions.h"

namespace terrazzo {

// Parts `particles` (non-zero: particle) into bodies of one colour, numbered from 1: patches merged as long
// as the squared error per length of border stays below ten pixels times the picture's colour variance, which
// mottling does not reach and two materials do. Slivers and what lies mostly inside another body join it.
std::vector<std::int32_t> color_bodies(const Mosaic&, const std::vector<std::uint8_t>& particles,
                                       const std::vector<bool>& patch_is_particle, double min_area,
                                       const Work&);

}  // namespace terrazzo
