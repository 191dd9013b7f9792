// Meshes of elementary solids: centered at the origin, watertight, facing outwards.
#pragma once

#include "nodes/data/shapes.h"
#include "nodes/shapes/shape/solid_kind.h"

namespace terrazzo::shape {

// `extents` is the bounding box, mm. An ellipsoid has 20·4^detail triangles (a subdivided and projected
// icosahedron). The vertices of curved solids are moved outwards by one factor so that the volume is exact,
// because a tessellation inscribed in a convex solid would lack up to some percent of it.
Mesh ellipsoid_mesh(const Vec3& extents, int detail);
Mesh box_mesh(const Vec3& extents);
// Axis along z; 8·2^detail equal sides; flat ends.
Mesh cylinder_mesh(const Vec3& extents, int detail);
// (|x/a|^(2/ε₂) + |y/b|^(2/ε₂))^(ε₂/ε₁) + |z/c|^(2/ε₁) = 1 on the grid of a cube, 12·4^detail triangles; ε in
// [0.1, 2.5] (Barr 1981). (1, 1) is the ellipsoid, small values are box-like, (2, 2) is an octahedron.
Mesh superquadric_mesh(const Vec3& extents, double e1, double e2, int detail);
// Tetrahedron, Octahedron, Dodecahedron or Icosahedron, regular, with edge 1.
Mesh platonic_mesh(SolidKind);

}  // namespace terrazzo::shape
