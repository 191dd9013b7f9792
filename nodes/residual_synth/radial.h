// Heeger and Bergen's pyramid taken to three dimensions as it stands, for comparison.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/residual_synth/exemplar.h"

namespace terrazzo {

// A tileable volume of colour offsets with mean 0, x fastest, whose bands of radial frequency *in the volume*
// get the values of the picture's bands of radial frequency: 2004 paper, section 4.3. A slice of it projects
// higher frequencies down, so that slices come out with the wrong bands. `exemplar` is measured with one
// orientation; its first picture counts. Needs 96 bytes a voxel.
std::vector<Vec3f> synthesize_radial(const Exemplar&, const Vec3i& size, int rounds, std::uint64_t seed,
                                     const Work& = {});

}  // namespace terrazzo
