// Fewer triangles for the contact search. The audit tests the original meshes.
#pragma once

#include <cstddef>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::packing {

struct Simplified {
  Mesh mesh;
  double deviation = 0;  // largest distance found between the two surfaces, mm
};

// Reduces a mesh to `fewest` triangles, or to `step` times as many and so on, until the surfaces are within
// `tolerance` (mm) of each other. Returns the mesh itself if that needs more than 1/`step` of its triangles,
// or if its surface touches itself along an edge.
Simplified simplified(const Mesh& mesh, double tolerance, const Work& work = {}, std::size_t fewest = 2500,
                      double step = 2);

}  // namespace terrazzo::packing
