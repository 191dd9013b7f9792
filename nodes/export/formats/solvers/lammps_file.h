// Particles as spheres of the same volume, for LAMMPS and LIGGGHTS (.lmp): a data file for atom_style sphere
// (LIGGGHTS: granular). SI units.
#pragma once

#include <filesystem>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/export/formats/solvers/materials.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// The atom type is 1 + class. Without `materials` (null), the density is 1000 kg/m³. Voids are left out.
// Throws Error "no-particles", "no-material" (a class without density), "bad-particles", "write-failed".
void write_lammps(const std::filesystem::path&, const Particles&, const Shapes&, const SolverMaterials*,
                  const Work& = {});

}  // namespace terrazzo::exporting
