// A Shape from a mesh: centred, checked, with every measure filled.
#pragma once

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo {

// Largest section area over all planes: search over quasi-random directions with exact depth, then local
// ascent. mm².
double max_section_area(const Mesh&, const Work& = {});

// Moves the centroid to the origin and fills volume, area, caliper and largest section.
// Throws Error "open-mesh" where mesh_faults finds any, "no-volume" where the volume is not positive.
Shape measure_shape(std::string name, Mesh mesh, double probability = 1, const Work& = {});

// Divides the probabilities by their sum. Throws Error "bad-probabilities" where one is negative or all are
// zero.
void normalise_probabilities(Shapes&);

}  // namespace terrazzo
