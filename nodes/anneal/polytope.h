// A convex polyhedron as the separating axis test wants it: whole faces, edges with both their faces.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::anneal {

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
  std::vector<Edge> edges;  // that faces meet in; none within a flat face
  bool empty() const { return faces.empty(); }
};

// Triangles of one plane are merged (to 1e-5 of the radius). Empty where the mesh is not convex or has more
// than `most` faces.
Polytope make_polytope(const Mesh& mesh, std::size_t most);

}  // namespace terrazzo::anneal
