// The bodies of a mesh file.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::load_mesh {

// The connected surfaces of a mesh, each with vertices of its own, in the order of their first triangles.
// Triangles are connected at edges. At an edge where several bodies touch, each body keeps the two triangles
// between which it lies.
std::vector<Mesh> connected_surfaces(const Mesh&);

struct Bodies {
  std::vector<Mesh> bodies;           // a surface that faces outward, with those of its cavities
  std::vector<std::size_t> inverted;  // surfaces that face inward and lie in no body
  std::vector<std::size_t> flat;      // surfaces that enclose no volume
};
// Sorts closed surfaces into bodies. A surface that faces inward is a cavity of the smallest body around it.
Bodies bodies_of(const std::vector<Mesh>& surfaces, const Work& = {});

}  // namespace terrazzo::load_mesh
