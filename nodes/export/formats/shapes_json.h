// Shapes as JSON with their meshes.
#pragma once

#include <nlohmann/json.hpp>

#include "nodes/data/shapes.h"

namespace terrazzo::exporting {

// What `terrazzo show --json` prints, and for each shape the field `mesh`: `vertices` ([x, y, z] in mm) and
// `triangles` ([i, j, k] from 0); also `color` ([r, g, b] of each vertex, scene-linear) and `uv` (six numbers
// for each triangle, u and v of its corners) if the shape has them. LoadShapes reads it.
nlohmann::json json_with_meshes(const Shapes&);

}  // namespace terrazzo::exporting
