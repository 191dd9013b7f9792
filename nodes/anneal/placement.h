// First positions of particles: at random, largest first, each where it overlaps least among some tries.
#pragma once

#include "nodes/anneal/relaxation.h"

namespace terrazzo::anneal {

// Gives particles `first` and later a random position and a uniformly random orientation; those before keep
// theirs. `radius`: a ball that stands for each particle here, mm. The later particles must be in order of
// falling radius.
void place_at_random(Packing& packing, std::size_t first, const std::vector<double>& radius,
                     std::uint64_t seed, const Work& work);

}  // namespace terrazzo::anneal
