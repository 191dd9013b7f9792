// A bed of loose stones: all fall onto a floor, in a box that is periodic in x and y, until they rest on each
// other.
#pragma once

#include "nodes/packing/rigid/packing.h"

namespace terrazzo::packing {

// The particles of populate() in a box with the edges options.edges, or an automatic one. They start in
// random places, far apart, and directions. The result's box is as wide, begins at the floor and ends with
// the highest stone, with air above the others. Stones are taken for convex bodies with up to 42 corners, so
// they may overlap by a few percent of their size. Throws the errors of populate(), and "too-many-particles"
// beyond 50,000.
PackResult deposit_particles(const SizeDistribution& distribution, const Shapes& shapes,
                             const PopulationOptions& options, const Work& work = {});

}  // namespace terrazzo::packing
