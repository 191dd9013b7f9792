// The recipe of Laursen, Ersbøll and Bærentzen 2011, for comparison.
#pragma once

#include <vector>

#include "nodes/solid_optimize/solid_optimize.h"

namespace terrazzo::solid_optimize {

// One level: the nearest patch by a k-d tree (ε = 2) for each, weights ‖d‖^(r − 2), the dominant cluster of
// the texels over each voxel by merging within `window` (in the field's units at the level's start; it falls
// to a tenth), 16-bin histograms that are kept up to date while voxels are visited in random order.
// Histograms count in units of the mean bin, one per exemplar; each texel is held against its own exemplar's.
void optimize_by_papers(const std::vector<const ExemplarLevel*>&, std::vector<MatchFamily>&, int iterations,
                        double exponent, double window, std::uint64_t seed, SolidField&, const Work&);
// The field at another size, trilinear, periodic.
SolidField resample(const SolidField&, const Vec3i& size, const Work&);

}  // namespace terrazzo::solid_optimize
