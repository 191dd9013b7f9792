// The kinds of solids, in the order of the words of the parameter `kind`.
#pragma once

namespace terrazzo::shape {

enum class SolidKind {
  Sphere,
  Ellipsoid,
  Box,
  Cylinder,
  Tetrahedron,
  Octahedron,
  Dodecahedron,
  Icosahedron,
  Superquadric,
  Rock,  // this and the others are random stones
  Pebble,
  Shard,
  Clinker
};

}  // namespace terrazzo::shape
