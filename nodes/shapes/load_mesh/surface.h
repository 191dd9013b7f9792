// A mesh file as one surface for texture maps, which need not be closed.
#pragma once

#include "nodes/data/shapes.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "runtime/work.h"

namespace terrazzo::load_mesh {

// All triangles at their place, with texture coordinates if the file has them. Equal positions become one
// vertex; triangles keep their order. The shape has an area, but no volume and no size. Throws the errors of
// triangles_of.
Shape surface_of(const PolygonSoup&, const Work& = {});

}  // namespace terrazzo::load_mesh
