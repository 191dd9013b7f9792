// Triangulation of closed polygons in space.
#pragma once

#include <functional>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::load_mesh {

inline constexpr std::size_t kLargestPolygon = 250;  // corners; the search is cubic in their number

// Returns the triangulation of least total area (Barequet, Sharir 1995), as indices into `polygon`, in its
// orientation. `forbidden(i, j)` excludes a diagonal. Returns nothing if no triangulation exists or `polygon`
// has more than kLargestPolygon corners.
std::vector<Triangle> least_area_triangulation(const std::vector<Vec3>& polygon,
                                               const std::function<bool(int, int)>& forbidden = {});

}  // namespace terrazzo::load_mesh
