// Shapes as triangle meshes for other programs, in mm with z up.
#pragma once

#include <filesystem>

#include "nodes/data/shapes.h"

namespace terrazzo::exporting {

// The extension selects the format: .obj (one object per shape), .ply (binary, one shape), .stl (binary, one
// shape). Colors of vertices are written sRGB-encoded: in .obj after the position, in .ply as bytes, in .stl
// not. Throws Error "no-shapes", "one-shape-only" (.ply and .stl hold one mesh), "write-failed".
void write_mesh(const std::filesystem::path&, const Shapes&);

}  // namespace terrazzo::exporting
