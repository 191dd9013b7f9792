// Surfaces of a volume's regions as files: Gmsh (.msh, version 2.2) and .stl. Lengths are mm.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/export/regions.h"
#include "nodes/export/surface_net.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// ASCII. Each patch is a physical surface: PARTICLE_3-BINDER, or PARTICLE_3-X0 at a side. Patches on the
// sides x1, y1 and z1 are periodic images of those on x0, y0 and z0 (section Periodic). Throws Error
// "write-failed".
void write_msh(const std::filesystem::path&, const SurfaceNet&, const Regions&, const Work& = {});

// Binary: the closed surface of all particles together, without voids and the binder, cut at the box's sides.
// Throws Error "no-particles" if there is no solid, "too-large" beyond 2³² − 1 triangles, "write-failed".
void write_surface_stl(const std::filesystem::path&, const SurfaceNet&, const Regions&, const Work& = {});

}  // namespace terrazzo::exporting
