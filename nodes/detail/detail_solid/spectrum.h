// Gives a tile's slices the power spectrum of a phase's grain.
#pragma once

#include <vector>

#include "nodes/detail/detail_solid/phases.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// Filters the tile (size³ voxels, x fastest) such that its slices have the radial power spectrum of
// `phases.offset` within one phase, along each of its principal axes, which are about lightness and two
// chromas. The photograph's spectrum is estimated from the covariance of pairs of used pixels up to 24 pixels
// apart (Blackman, Tukey 1958), so it does not depend on the shape of what is used. Amplitudes along an axis
// change by a factor of at most 0.1 to 4 relative to their mean.
void match_spectrum(std::vector<Vec3f>& tile, int size, const Phases& phases, int phase, const Work& = {});

}  // namespace terrazzo::detail_solid
