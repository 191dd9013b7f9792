// The reference method of Laursen, Ersbøll and Bærentzen 2011, for comparison.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/options/solid_options.h"
#include "nodes/solids/synthesis/whole/result.h"

namespace terrazzo::solids {

// Optimizes one level. Each patch gets the nearest exemplar patch by a k-d tree (ε = 2) and the weight ‖d‖^(r
// − 2). Each voxel gets the dominant cluster of the texels over it, found by merging within `window` (in the
// field's units at the level's start; it falls to a tenth). 16-bin histograms are kept up to date while
// voxels are visited in random order. They count in units of the mean bin, one per exemplar; each texel is
// compared with its own exemplar's histogram.
void optimize_by_reference(const std::vector<const ExemplarLevel*>&, std::vector<NeighborField>&,
                           int iterations, double exponent, double window, std::uint64_t seed, SolidField&,
                           const Work&);
// Resamples the field to another size, trilinear, periodic.
SolidField resample(const SolidField&, const Vec3i& size, const Work&);

}  // namespace terrazzo::solids
