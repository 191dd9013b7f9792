// What makes a job for Abaqus and CalculiX out of a mesh of inp_file.h: materials and sections, and a step.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/particles.h"
#include "nodes/export/formats/solvers/materials.h"

namespace terrazzo::exporting {

// *MATERIAL per phase, in MPa and tonnes per mm³; *SOLID SECTION per region with voxels, with the
// *ORIENTATION of the particle if the phase is not isotropic. Throws the errors of
// SolverMaterials::require_stiffness, Error "write-failed".
void write_inp_materials(const std::filesystem::path&, const Regions&, const SolverMaterials&,
                         const Particles*);

// The names of files that a job includes; "" is left out.
struct InpJob {
  std::string mesh, equations, materials;
};
// Throws Error "bad-names" if *INCLUDE cannot read a name.
void check_inp_job(const InpJob&);
// A job for CalculiX, which stretches the box along x by 0.001. Sides are periodic with equations; otherwise
// X0, Y0 and Z0 slide and Y1 and Z1 are free. Throws Error "write-failed".
void write_inp_job(const std::filesystem::path&, const InpJob&, const VoxelBox&);

}  // namespace terrazzo::exporting
