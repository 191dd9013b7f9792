// Closed meshes, cut at the sides of a periodic box.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo::exporting {

// The parts of a closed mesh in the cells of a periodic box, each moved into the box and closed by flat caps
// on its sides. Vertices on a side have exactly the coordinate 0 or that of the edge, and outlines on
// opposite sides are equal to the bit, so parts of neighboring boxes join. Throws Error "open-mesh" if the
// mesh is not closed.
std::vector<Mesh> parts_in_box(const Mesh&, const Vec3& box);

// The part of a closed mesh below `at` along an axis, or above it, closed by a flat cap. A vertex on the
// plane belongs to no part. Throws Error "open-mesh".
Mesh cut_mesh(const Mesh&, int axis, double at, bool below);

// The mesh with vertices of their own for triangles on the sides of the box, so that smooth shading does not
// bend around the edges of caps.
Mesh with_flat_caps(const Mesh&, const Vec3& box);

}  // namespace terrazzo::exporting
