// Spheres of nearly equal triangles.
#pragma once

#include "nodes/data/shapes.h"

namespace terrazzo {

// Edge 1, about the origin, outwards.
Mesh icosahedron_mesh();

// An icosahedron, each triangle split in four and projected `detail` times: 20·4^detail triangles of the unit
// sphere.
Mesh geodesic_sphere(int detail);

}  // namespace terrazzo
