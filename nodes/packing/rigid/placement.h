// Initial positions of particles: random, largest first, each at the position with the least
// overlap among several tries.
#pragma once

#include "nodes/packing/rigid/population/clusters.h"
#include "nodes/packing/rigid/relaxation.h"

namespace terrazzo::packing {

// Assigns random positions and uniformly random orientations to the particles from `first` on; the others are
// unchanged. `radius`: a ball that represents each particle, mm. The particles from `first` on must be in
// order of decreasing radius. Particles smaller than `clusters.below` are placed in clusters between the
// others.
void place_at_random(Packing& packing, std::size_t first, const std::vector<double>& radius,
                     std::uint64_t seed, const Work& work, const Clusters& clusters = {});

}  // namespace terrazzo::packing
