// From polygons as a file has them to a mesh that bounds a solid.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/load_mesh/read_mesh.h"
#include "runtime/work.h"

namespace terrazzo {

// Polygons become triangles: of all triangulations of a polygon the one of least area (Barequet, Sharir
// 1995), so that bent and non-convex ones are covered too. Throws Error "bad-mesh" for polygons of more than
// 250 corners that are not convex and flat.
Mesh triangles_of(const PolygonSoup&, const Work& = {});

// Joins vertices closer than `distance` (0: of equal position) and drops triangles that vanish by it. Returns
// how many vertices went.
std::size_t weld(Mesh&, double distance);

// What was done, in words ("filled 2 holes with 14 triangles"), for the user to judge; empty where nothing
// had to be. Welds within 1e-6 of the extent, drops degenerate and doubled triangles and unused vertices,
// turns triangles to one orientation with the outside out, fills holes of at most 250 edges by the
// triangulation of least area. What it cannot mend (edges of three and more triangles, one-sided surfaces)
// stays for mesh_faults to tell.
std::vector<std::string> repair(Mesh&, const Work& = {});

}  // namespace terrazzo
