// Intersection and distance of two triangles.
#pragma once

#include <array>

#include "nodes/data/linear.h"

namespace terrazzo::packing {

using Corners = std::array<Vec3, 3>;

// The shortest translation that separates two triangles, mm; 0 if they only touch, −1 if they are apart.
// Separating axes: both normals, the nine cross products of edges, and the in-plane edge normals, which
// matter for coplanar triangles (Gottschalk 1996).
double triangle_penetration(const Corners& a, const Corners& b);

// Distance of two triangles that do not intersect.
double triangle_distance(const Corners& a, const Corners& b);

}  // namespace terrazzo::packing
