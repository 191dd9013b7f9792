// Joins the size distributions of several kinds of particles into one population.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"

namespace terrazzo::mix_distributions {

struct Mixture {
  SizeDistribution distribution;
  Shapes shapes;
};

// Distribution i belongs to the set of shapes i. Its color or particle classes get the numbers after those of
// the distributions before it, and its shapes belong to them; an entry for any shape is divided among the
// shapes of its set by their probabilities. The size classes have the edges of all distributions, sizes being
// uniform within a class. The probabilities of the shapes follow from the number densities. Densities add
// up, and so do the volume fractions. Throws Error "wrong-count" (one set of shapes per distribution),
// "bad-distribution", "relative-densities" (a distribution without a volume fraction), "mixed-classes" (a
// shape for any of several classes), "too-dense" (a volume fraction above 1).
Mixture mix(const std::vector<const SizeDistribution*>&, const std::vector<const Shapes*>&);

}  // namespace terrazzo::mix_distributions
