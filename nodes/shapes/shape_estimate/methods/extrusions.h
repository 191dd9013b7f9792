// The exact intersection of three extruded polygons.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

using Polygon = std::vector<Vec2>;  // simple, counter-clockwise

// The solid of all points (x₀, x₁, x₂) with (x_k, x_k+1) in polygon k for k = 0, 1, 2 (indices mod 3). Every
// face lies on the extrusion of an edge; every vertex is where three such faces meet or where a face crosses
// the line over a corner. Faces are clipped in their own planes and joined by the edges that created their
// corners, so that the mesh closes without a search for nearby points. Polygons in special position (parallel
// edges, corners on edges) are randomly perturbed by up to 1e-7 of their extent until the mesh closes. If
// there are several pieces, the largest is kept. Empty if the extrusions do not intersect. Throws Error
// "no-intersection" if no perturbation helps.
Mesh intersect_extrusions(const std::array<Polygon, 3>& polygons, const Work& = {});

// Removes points that are at most `distance` from the remaining polygon (Douglas and Peucker 1973).
Polygon simplified(const Polygon&, double distance);

}  // namespace terrazzo::shape_estimate
