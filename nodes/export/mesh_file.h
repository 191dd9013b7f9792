// Shapes as triangle meshes for other programs, in mm and with z up as here.
#pragma once

#include <filesystem>

#include "nodes/data/shapes.h"

namespace terrazzo {

// By extension: .obj (one object a shape), .ply (binary, one shape), .stl (binary, one shape).
// Throws Error "no-shapes", "one-shape-only" (.ply and .stl hold one mesh), "write-failed".
void write_mesh(const std::filesystem::path&, const Shapes&);

}  // namespace terrazzo
