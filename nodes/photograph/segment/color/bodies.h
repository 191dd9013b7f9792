// Separation of touching particles by color.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/color/mosaic.h"

namespace terrazzo::segment {

// Splits `particles` (non-zero: particle) into bodies of uniform color, numbered from 1. Patches merge while
// the squared error per length of border stays below six pixels times the picture's color variance. Mottling
// stays below this threshold; two different materials exceed it. Slivers and bodies mostly enclosed by
// another body join it.
std::vector<std::int32_t> color_bodies(const Mosaic&, const std::vector<std::uint8_t>& particles,
                                       const std::vector<bool>& patch_is_particle, double min_area,
                                       const Work&);

}  // namespace terrazzo::segment
