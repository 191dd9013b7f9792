// A mesh file as one surface for texture maps, which need not be closed.
#pragma once

#include "nodes/data/shapes.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "runtime/work.h"

namespace terrazzo::load_mesh {

// All triangles at their place, with texture coordinates if the soup has them. Equal positions become one
// vertex; triangles keep their order. The shape has an area, but no volume and no size. Throws the errors of
// triangles_of, and "too-large" if more than `memory` bytes would be needed.
Shape surface_of(const PolygonSoup&, std::uint64_t memory, const Work& = {});

}  // namespace terrazzo::load_mesh
