// Splitting of touching particles at their necks.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::segment {

// Exact squared distance of each pixel center to the nearest center of a pixel with another value, or to the
// outside of the raster if `border_is_outside` (Felzenszwalb and Huttenlocher 2012). 0 where the raster is 0.
std::vector<float> squared_distance(const std::vector<std::int32_t>& raster, int width, int height,
                                    bool border_is_outside, const Work&);

// Splits each non-zero value of `raster` into pieces numbered from 1. The pieces are the basins of the
// distance to the outline. Two basins stay together if the half-width of their neck is at least √strength of
// the smaller basin's, or less than a pixel below it (watershed with relative h-maxima; Soille 2003, 6.3).
// strength 0: splits only unconnected parts. strength 1: splits at every neck.
std::vector<std::int32_t> split_at_necks(const std::vector<std::int32_t>& raster, int width, int height,
                                         double strength, const Work&);

}  // namespace terrazzo::segment
