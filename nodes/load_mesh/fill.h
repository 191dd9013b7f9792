// Triangulations of closed polygons in space.
#pragma once

#include <functional>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

inline constexpr std::size_t kLargestPolygon = 250;  // corners; the search below is cubic in them

// Triangles (indices into `polygon`'s own points, in its direction) of least total area (Barequet, Sharir
// 1995). `forbidden(i, j)` tells diagonals that must not be used. Empty where none is possible or for too
// many corners.
std::vector<Triangle> least_area_triangulation(const std::vector<Vec3>& polygon,
                                               const std::function<bool(int, int)>& forbidden = {});

}  // namespace terrazzo
