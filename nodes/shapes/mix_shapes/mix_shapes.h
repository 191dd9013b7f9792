// Joins several sets of shapes into one population.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::mix_shapes {

// Set i has the share `shares[i]` of the particles by number, divided among its shapes by their
// probabilities. Shares need not sum to 1. Throws Error "bad-probabilities" if a share is negative or none is
// positive, "wrong-count" if the numbers of shares and sets differ.
Shapes mix(const std::vector<const Shapes*>& sets, const std::vector<double>& shares);

}  // namespace terrazzo::mix_shapes
