// What DAMASK 3 reads beside the voxels of a .vti file: material.yaml and a load case. SI units.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/data/particles.h"
#include "nodes/export/formats/solvers/materials.h"

namespace terrazzo::exporting {

// Throws Error "bad-materials" if DAMASK does not know the lattice of a region's phase, or needs its c/a, and
// the errors of SolverMaterials::require_stiffness.
void check_damask(const Regions&, const SolverMaterials&, const Particles*);

// One entry of `material` per region, in order: its phase and the orientation of the particle. `regions`:
// only those that have voxels. `particles` may be null. `provenance`: JSON for a comment, or empty. Throws
// Error "write-failed".
void write_damask_material(const std::filesystem::path&, const Regions&, const SolverMaterials&,
                           const Particles*, const std::string& provenance);

// Uniaxial tension along x at 0.001 per second to a strain of 0.001. Throws Error "write-failed".
void write_damask_load(const std::filesystem::path&);

}  // namespace terrazzo::exporting
