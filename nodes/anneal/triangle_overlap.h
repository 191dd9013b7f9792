// Do two triangles meet, and how deep.
#pragma once

#include <array>

#include "nodes/common/linear.h"

namespace terrazzo::anneal {

using Corners = std::array<Vec3, 3>;

// The least translation that parts two triangles, mm; 0 where they only touch, −1 where they are apart.
// Separating axes: both normals, the nine cross products of edges, and the in-plane edge normals, which
// matter where the triangles are coplanar (Gottschalk 1996).
double triangle_penetration(const Corners& a, const Corners& b);

// Distance of two triangles that do not cross.
double triangle_distance(const Corners& a, const Corners& b);

}  // namespace terrazzo::anneal
