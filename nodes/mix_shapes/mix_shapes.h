// Several sets of shapes as one population.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::mix_shapes {

// Set i gets the share `shares[i]` of the particles by number, divided within by its own probabilities;
// shares need not sum to 1. Throws Error "bad-probabilities" where one is negative or none positive,
// "wrong-count" where there are not as many as sets.
Shapes mix(const std::vector<const Shapes*>& sets, const std::vector<double>& shares);

}  // namespace terrazzo::mix_shapes
