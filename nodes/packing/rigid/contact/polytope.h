// A convex polyhedron for the separating axis test: whole faces, and edges with both their faces.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::packing {

struct Polytope {
  struct Face {
    Vec3f normal;                    // outward, unit
    float offset;                    // normal·x of the face
    std::vector<std::int32_t> loop;  // counter-clockwise from outside
  };
  struct Edge {
    std::int32_t a, b;
    Vec3f direction;           // unit, from a to b
    std::int32_t left, right;  // faces
  };
  std::vector<Vec3f> vertices;
  std::vector<Face> faces;
  std::vector<Edge> edges;  // only edges between faces, none within a flat face
  bool empty() const { return faces.empty(); }
};

// Merges coplanar triangles (to 1e-5 of the radius). Empty if the mesh is not convex or has
// more than `most` faces.
Polytope make_polytope(const Mesh& mesh, std::size_t most);

}  // namespace terrazzo::packing
