// Makes a Shape from a mesh: centered, checked, with all measures computed.
#pragma once

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo {

// Area of the largest section over all planes in mm²: a search over quasi-random directions with exact depth,
// then local ascent.
double max_section_area(const Mesh&, const Work& = {});
// The same from few directions, for thousands of meshes. Too small by 0.3 % on average and by at most 3 % for
// 1,000 Laguerre cells.
double quick_max_section_area(const Mesh&);

// Moves the centroid to the origin and computes volume, surface area, mean caliper diameter and largest
// section.
// Throws Error "open-mesh" if mesh_faults finds any, "no-volume" if the volume is not positive.
Shape measure_shape(std::string name, Mesh mesh, double probability = 1, const Work& = {});

// Divides the probabilities by their sum. Throws Error "bad-probabilities" if one is negative or all are
// zero.
void normalize_probabilities(Shapes&);

}  // namespace terrazzo
