// Meshes as graphics wants them: one normal per vertex, corners split where the surface is faceted.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

struct RenderMesh {
  std::vector<Vec3> positions;         // mm
  std::vector<Vec3> normals;           // unit, one a position
  std::vector<std::uint32_t> indices;  // three a triangle, counter-clockwise seen from outside
};

// Smooth: normals are the triangles' weighted by their angle at the vertex (Thürmer and Wüthrich 1998).
// Faceted: every triangle has its own three vertices. Triangles without area are left out. Throws Error
// "bad-number" where a vertex is not finite, "bad-mesh" where an index points nowhere or nothing is left.
RenderMesh render_mesh(const Shape&);

}  // namespace terrazzo
