// Heeger and Bergen's pyramid extended directly to three dimensions, for comparison.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/detail/residual_synth/exemplar.h"

namespace terrazzo::residual_synth {

// Returns a tileable volume of color offsets with mean 0, x fastest. Bands of radial frequency *in the
// volume* are matched to the picture's bands of radial frequency (2004 paper, section 4.3). A slice projects
// higher frequencies down, so slices have the wrong bands. `exemplar` must be measured with one orientation;
// only its first picture is used. Needs 96 bytes per voxel.
std::vector<Vec3f> synthesize_radial(const Exemplar&, const Vec3i& size, int rounds, std::uint64_t seed,
                                     const Work& = {});

}  // namespace terrazzo::residual_synth
