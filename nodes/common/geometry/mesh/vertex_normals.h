// Smooth normals of a mesh.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

// Unit normals at the vertices: means over their triangles, weighted by area. Zero at a vertex without area.
std::vector<Vec3> vertex_normals(const Mesh&);

}  // namespace terrazzo
