// Shapes and packings as triangle meshes for other programs, in mm with z up.
#pragma once

#include <filesystem>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// The extension selects the format: .obj (one object per shape), .ply (binary, one shape), .stl (binary, one
// shape). Colors of vertices are written sRGB-encoded: in .obj after the position, in .ply as bytes, in .stl
// not. Throws Error "no-shapes", "one-shape-only" (.ply and .stl hold one mesh), "write-failed".
void write_mesh(const std::filesystem::path&, const Shapes&);

// All particles but voids, each in its place: in .obj one object SHAPE_INDEX each, in .ply and .stl one mesh.
// Shapes without colors have those of the particles. Throws the errors of instances_of, Error "too-large"
// (.ply, .stl: beyond their numbers of triangles), "write-failed".
void write_mesh(const std::filesystem::path&, const Particles&, const Shapes&, const Work& = {});

}  // namespace terrazzo::exporting
