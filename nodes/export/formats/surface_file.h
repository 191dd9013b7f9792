// Surfaces of a volume's regions as files: Gmsh (.msh, version 2.2) and .stl. Lengths are mm.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/export/regions.h"
#include "nodes/export/surface_net.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// ASCII. Patches between the same regions are one physical surface: PARTICLE_3-BINDER, or PARTICLE_3-X0 at a
// side. Each patch is an elementary surface. Patches on the sides x1, y1 and z1 are periodic images of those
// on x0, y0 and z0 (section Periodic). Throws Error "write-failed".
void write_msh(const std::filesystem::path&, const SurfaceNet&, const Regions&, const Work& = {});

// A script for Gmsh that merges the file `msh` beside it and defines a volume for each piece and a physical
// volume for each region, so that `gmsh -3` fills them with tetrahedra. Throws Error "bad-names" if the name
// contains a quotation mark or backslash, "write-failed".
void write_geo(const std::filesystem::path&, const std::string& msh, const SurfaceNet&, const Regions&);

// Binary: the closed surface of all particles together, without voids and the binder, cut at the box's sides.
// Throws Error "no-particles" if there is no solid, "too-large" beyond 2³² − 1 triangles, "write-failed".
void write_surface_stl(const std::filesystem::path&, const SurfaceNet&, const Regions&, const Work& = {});

}  // namespace terrazzo::exporting
