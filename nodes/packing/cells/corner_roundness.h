// How round the corners of profiles are.
#pragma once

#include "nodes/data/profiles.h"

namespace terrazzo::tessellation {

// The roundness (see round_edges) of a pentagon, the average section of cells that fill space, whose outline
// bends as sharply as the median of the profiles' outlines: by the curvature that a tenth of an outline
// exceeds. 0 (sharp) to 1; 0 too with fewer than three whole profiles of at least 24 points.
double measure_roundness(const Profiles& profiles);

}  // namespace terrazzo::tessellation
