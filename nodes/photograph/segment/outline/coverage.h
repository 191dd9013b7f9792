// Particle coverage of each pixel, estimated from the image.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/color/mosaic.h"

namespace terrazzo::segment {

// Moves the outline of `particles` (non-zero: particle) to where the color is half-way between the local mean
// colors of both sides (normalized convolution), by at most three pixels. Returns the coverage of every
// pixel: 1 and 0 away from the outline, values in between at the outline. The coverage agrees with the mask:
// it is ≥ ½ exactly where the mask is non-zero. Where both sides differ by less than 4 × the noise, the mask
// is kept and its smoothed edge determines the coverage.
std::vector<float> refine_outline(const Mosaic&, std::vector<std::uint8_t>& particles, const Work&);

// The share on its pixel's side of one half: a coverage of exactly ½ would put the outline on a pixel center.
float sided(float share, bool inside);

// Coverage from a mask only, by smoothing its edge.
std::vector<float> smooth_coverage(const std::vector<std::int32_t>& labels, int width, int height,
                                   const Work&);

}  // namespace terrazzo::segment
