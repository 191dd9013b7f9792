// Touching particles parted at their necks.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo {

// Squared distance of each pixel's centre to the nearest centre of a pixel of another value, or to the
// outside beyond the raster where `border_is_outside`; exact (Felzenszwalb and Huttenlocher 2012). 0 where
// the raster is 0.
std::vector<float> squared_distance(const std::vector<std::int32_t>& raster, int width, int height,
                                    bool border_is_outside, const Work&);

// Parts each non-zero value of `raster` into pieces numbered from 1: the basins of the distance to its
// outline, two of them staying one where their neck is wider than √strength of the thinner one, or no thinner
// by a pixel (watershed with relative h-maxima; Soille 2003, 6.3). strength 0: connected parts only; 1: at
// every neck.
std::vector<std::int32_t> split_at_necks(const std::vector<std::int32_t>& raster, int width, int height,
                                         double strength, const Work&);

}  // namespace terrazzo
