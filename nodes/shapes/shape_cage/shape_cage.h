// Control cages: coarse meshes whose subdivision surface is a shape, so that the shape can be edited by
// moving a few vertices.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_cage {

struct Cage {
  Mesh control;  // a closed triangle mesh; its Loop subdivision surface is the shape
  double mean_error = 0, largest_error = 0;  // mm, between shape and surface, both ways
};

// Reduces the mesh to about `vertices` vertices and moves these until the limit surface fits the mesh:
// closest points and least squares, alternately, `iterations` times. Throws the errors of reduce_triangles().
Cage fit_cage(const Mesh&, int vertices, int iterations, const Work& = {});

// The limit surface of Loop subdivision, each triangle split into 4^level.
Mesh limit_surface(const Mesh& control, int level);

struct Move {
  int vertex = 0;
  Vec3 by = Vec3::Zero();  // mm
};
// Parses "12 0.5 0 -1": a vertex and how far it moves along x, y and z, mm. Throws Error "bad-move" for the
// parameter `moves`.
Move parse_move(const std::string&);
// Throws Error "bad-move" for the parameter `moves` if there is no such vertex.
void move_vertices(Mesh& control, const std::vector<Move>&);

}  // namespace terrazzo::shape_cage
