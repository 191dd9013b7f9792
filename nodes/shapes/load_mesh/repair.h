// Converts polygons from a file to a mesh that bounds a solid.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "runtime/work.h"

namespace terrazzo::load_mesh {

// Triangulates each polygon with the least total area (Barequet, Sharir 1995), which also covers bent and
// non-convex polygons. Throws Error "bad-mesh" for polygons with more than 250 corners that are not convex
// and flat.
Mesh triangles_of(const PolygonSoup&, const Work& = {});

// Joins vertices within `distance` of each other (0: of equal position) and drops triangles that become
// degenerate. Returns the number of vertices removed.
std::size_t weld(Mesh&, double distance);

// Joins vertices within 1e-6 of the extent, drops degenerate and duplicate triangles and unused vertices,
// orients all triangles outward, and fills holes of up to 250 edges with the triangulation of least area.
// Returns a description of each change for the user ("filled 2 holes with 14 triangles"), nothing if nothing
// changed. Edges of three or more triangles and one-sided surfaces cannot be repaired; mesh_faults reports
// them.
std::vector<std::string> repair(Mesh&, const Work& = {});

}  // namespace terrazzo::load_mesh
