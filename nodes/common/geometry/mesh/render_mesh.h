// Meshes for rendering: one normal per vertex, with vertices duplicated where the surface is faceted.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

struct RenderMesh {
  std::vector<Vec3> positions;          // mm
  std::vector<Vec3> normals;            // unit vectors, one per position
  std::vector<std::uint32_t> indices;   // three per triangle, counterclockwise seen from outside
  std::vector<std::uint32_t> vertex;    // the shape's vertex at each position
  std::vector<std::uint32_t> triangle;  // the shape's triangle of every three indices
};

// Smooth shapes: vertex normals are the mean of the triangles' normals, weighted by angle (Thürmer and
// Wüthrich 1998). Faceted shapes: every triangle has its own three vertices. Triangles without area are
// dropped. Throws Error "bad-number" if a vertex is not finite, "bad-mesh" if an index is out of range or no
// triangle is left.
RenderMesh render_mesh(const Shape&);

}  // namespace terrazzo
