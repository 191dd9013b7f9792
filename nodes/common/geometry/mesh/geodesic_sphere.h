// Sphere meshes of nearly equal triangles.
#pragma once

#include "nodes/data/shapes.h"

namespace terrazzo {

// Edge length 1, centered at the origin, facing outwards.
Mesh icosahedron_mesh();

// Unit sphere of 20·4^detail triangles: an icosahedron whose triangles are split in four and projected
// `detail` times.
Mesh geodesic_sphere(int detail);

}  // namespace terrazzo
