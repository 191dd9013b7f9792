// Finer triangles for a body, and rounder edges.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::shape_estimate {

// Splits edges longer than `limit` in rounds, if they are the longest edge of both their triangles.
void split_edges(Mesh&, double limit);

// Laplacian smoothing: moves vertices halfway to the mean of their neighbors, `rounds` times.
std::vector<Vec3> smoothed(const Mesh&, int rounds);

}  // namespace terrazzo::shape_estimate
