// The exact intersection of three extruded polygons.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

using Polygon = std::vector<Vec2>;  // simple, counter-clockwise

// The solid of all points (x₀, x₁, x₂) with (x_k, x_k+1) in polygon k for k = 0, 1, 2 (indices mod 3): every
// face lies on the extrusion of an edge, every vertex where three such faces meet or where one crosses the
// line over a corner. Faces are cut in their own planes and joined by which edges made their corners,
// so that the mesh closes without any search for near points. Polygons in special position (parallel edges,
// corners on edges) are moved by up to 1e-7 of their extent, each by lots, until it does; of several pieces
// the largest stays. Empty where nothing is common. Throws Error "no-intersection" where no lot helps.
Mesh intersect_extrusions(const std::array<Polygon, 3>& polygons, const Work& = {});

// Fewer points, none of the left-out ones further than `distance` from the polygon (Douglas and Peucker
// 1973).
Polygon simplified(const Polygon&, double distance);

bool polygon_contains(const Polygon&, const Vec2&);

}  // namespace terrazzo::shape_estimate
