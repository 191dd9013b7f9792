// Refinement of closed triangle meshes.
#pragma once

#include "nodes/data/shapes.h"

namespace terrazzo::tessellation {

// Splits edges longer than `longest` (mm, positive) at their midpoints until none is left. The surface stays
// the same, and the mesh closed.
void split_long_edges(Mesh& mesh, double longest);

// Splits the edges that cross the plane normal·x = offset where they cross it. Vertices within `near` (mm) of
// the plane count as on it.
void split_at_plane(Mesh& mesh, const Vec3& normal, double offset, double near);

}  // namespace terrazzo::tessellation
