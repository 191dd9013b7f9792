// Smooth surfaces over control meshes.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct ControlMesh {
  std::vector<Vec3> vertices;           // points to interpolate
  std::vector<std::vector<int>> faces;  // three or four corners, counter-clockwise from outside
  std::vector<std::array<int, 2>> crease_edges;
  std::vector<float> crease_sharpness;  // subdivision levels for which the edge stays sharp; ≥ 10: always
};

// The Catmull–Clark limit surface through the control mesh's vertices, tessellated after `level` subdivisions
// (OpenSubdiv). Plain Catmull–Clark would shrink away from its control points, so they are moved until the
// limit points of the vertices are the given ones, in `iterations` steps (progressive iterative
// approximation: Lin, Wei, Chen 2004).
Mesh interpolating_surface(const ControlMesh&, int level, int iterations = 20, const Work& = {});

}  // namespace terrazzo::shape_estimate
