// Simplification of meshes.
#pragma once

#include <cstddef>

#include "nodes/common/geometry/mesh/mesh.h"
#include "runtime/work.h"

namespace terrazzo {

// Collapses edges until at most `triangles` remain, those first that change the surface least (Garland and
// Heckbert 1997, by OpenMesh). The mesh stays closed. Collapses that would fold the surface are skipped, so
// slightly more triangles may remain. `mesh` must be closed and consistently oriented. Throws Error
// "bad-mesh" if surfaces touch along an edge or at a vertex.
void reduce_triangles(Mesh& mesh, std::size_t triangles, const Work& = {});

}  // namespace terrazzo
