// Cases for OpenFOAM: the surfaces of a volume's binder as a .stl file of named patches, and the dictionaries
// with which blockMesh and snappyHexMesh mesh it. Lengths are meters.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "nodes/export/surface_net.h"

namespace terrazzo::exporting {

// A solid per neighbor of the binder, named after it (Region::name); normals point out of the binder. Throws
// Error "no-particles" if it has none, "write-failed".
void write_foam_surface(const std::filesystem::path&, const SurfaceNet&, const Regions&, const Work& = {});

// A point inside of the binder, mm, as far from everything else as possible. Throws Error "no-binder".
Vec3 inside_of_binder(const VoxelSource& id, const VoxelBox&, const Regions&, std::uint64_t memory,
                      const Work&);

// The texts of the case by their paths below its folder. The background mesh has one cell per voxel, and the
// patches X0 … Z1. `stl`: the name of the surface's file.
std::map<std::string, std::string> foam_dictionaries(const std::string& stl, const SurfaceNet&,
                                                     const VoxelBox&, const Regions&, const Vec3& inside);

}  // namespace terrazzo::exporting
