// Makes a tile's spectrum alike in all directions.
#pragma once

#include <vector>

#include "nodes/common/texture/lane_fft.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// `data`: the transform of size³ voxels, x fastest. Multiplies its frequencies such that, at each distance
// from the origin, each lane has about the same power in all directions, seen through a window of about 25°.
// A solid whose slices across the axes look like the photograph may still consist of strokes along a
// diagonal, which oblique sections show. Factors are from 1/4 to 4.
void equalize_directions(std::vector<LaneComplex>& data, int size, const Work& = {});

}  // namespace terrazzo::detail_solid
