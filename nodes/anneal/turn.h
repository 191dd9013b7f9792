// Spheres are packed as spheres, though their meshes have facets whose corners lie beyond: each is turned so
// that no corner reaches beyond the plane between it and a neighbour.
#pragma once

#include <cstdint>

#include "nodes/anneal/relaxation.h"

namespace terrazzo::anneal {

// Turns the spheres among the bodies whose mesh reaches beyond its share of the distance (less `gap`, mm) to
// another sphere, at random until it does not: the plane between the two then parts them. All turn at once;
// the few that found no such turn in some thousand tries follow one by one and use what their neighbours
// leave. Places stay as they are.
void turn_spheres(const Shapes& meshes, const std::vector<ContactShape>& shapes, Packing& packing, double gap,
                  std::uint64_t seed, const Work& work);

}  // namespace terrazzo::anneal
