// How much of each pixel a particle covers, read from the picture.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/segment/regions.h"

namespace terrazzo {

// Moves the outline of `particles` (non-zero: particle) to where the picture's colour is half-way between the
// local mean colours on its two sides (normalised convolution), by at most two pixels, and gives the covered
// share of every pixel: 1 and 0 away from the outline, between at it. The share agrees with the mask: ≥ ½
// exactly where non-zero. Where the two sides differ by less than 6 × noise, the mask stays and its own
// smoothed edge gives the share.
std::vector<float> refine_outline(const Mosaic&, std::vector<std::uint8_t>& particles, const Work&);

// The same from a mask alone.
std::vector<float> smooth_coverage(const std::vector<std::int32_t>& labels, int width, int height,
                                   const Work&);

}  // namespace terrazzo
