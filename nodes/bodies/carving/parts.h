// A body as closed meshes, for those who need its geometry and not only its picture.
#pragma once

#include "nodes/bodies/carving/solid.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo::carving {

// The body is ((base − removed) ∪ kept) within `box`, in the world units of Solid. `removed` and `kept`
// consist of any number of closed meshes, or none.
struct BodyParts {
  Shape base;  // name, mesh and `smooth`, without measures
  Mesh removed, kept;
  Eigen::AlignedBox3d box;  // empty if nothing is cut off

  bool whole() const { return removed.triangles.empty() && kept.triangles.empty() && box.isEmpty(); }
};

// The parts of block_solid and object_solid with the same arguments, with holes where `voids` are.
BodyParts block_parts(const Vec3f& period, double cut, const Voids& voids = {});
BodyParts object_parts(const Shape& object, const Voids& voids = {});
// The parts of fracture_solid with the same arguments.
BodyParts fracture_parts(const Particles&, const Shapes&, double level, double roughness, std::uint64_t seed);

// The object's mesh with the longest side 1 and its lowest corner at the origin. Throws Error "bad-mesh".
Mesh placed_object(const Shape& object);

}  // namespace terrazzo::carving
