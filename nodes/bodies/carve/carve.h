// A body carved from a solid or broken along its particles, as a colored mesh and as a level set.
#pragma once

#include "nodes/bodies/carving/parts.h"
#include "nodes/bodies/carving/request.h"
#include "nodes/data/image.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::carve {

struct CarveOptions {
  double edge = 0;           // mm, longest edge of a triangle; edge of a voxel. 0: 1/200 of the longest side
  int texture = 0;           // pixels of the texture's edge; 0: none
  std::uint64_t memory = 0;  // bytes that may be allocated
};

struct CarvedMesh {
  Shape shape;    // mm, centroid at the origin, with colors and, with a texture, their coordinates
  Volume volume;  // `surface` and `Cd`, in the same place as the shape
  Image texture;  // without a texture, one pixel of the mean color
  double edge = 0;
};

// `body` is the solid of `parts`. Throws Error "too-large", "empty-body", "bad-value", "open-mesh".
CarvedMesh carve_mesh(const carving::BodyParts& parts, const carving::Body& body, const CarveOptions&,
                      const Work& = {});

}  // namespace terrazzo::carve
