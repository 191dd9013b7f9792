// Meshes of elementary solids, centred at the origin, watertight, outwards.
#pragma once

#include <string>

#include "nodes/data/shapes.h"

namespace terrazzo {

// Bounding box `extents`, mm. Curved solids carry 20·4^detail triangles (an icosahedron subdivided and
// projected) or what their comment says; their vertices are moved outwards by one factor so that the volume
// is the true one, since a tessellation inscribed in a convex solid would lack up to some per cent of it.
Mesh ellipsoid_mesh(const Vec3& extents, int detail);
Mesh box_mesh(const Vec3& extents);
// Axis along z, 8·2^detail sides of equal area share; ends flat.
Mesh cylinder_mesh(const Vec3& extents, int detail);
// |(|x/a|^(2/ε₂) + |y/b|^(2/ε₂))^(ε₂/ε₁) + |z/c|^(2/ε₁) = 1 on a cube's grid, 12·4^detail triangles; ε in
// [0.1, 2.5] (Barr 1981). 1, 1 is the ellipsoid, small values box-like, 2, 2 an octahedron.
Mesh superquadric_mesh(const Vec3& extents, double e1, double e2, int detail);
// Regular "tetrahedron", "octahedron", "dodecahedron" or "icosahedron" of edge 1.
Mesh platonic_mesh(const std::string& kind);

}  // namespace terrazzo
