// Permeability of a voxel model: slow viscous flow, −Δu + ∇p = g, ∇·u = 0.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/properties/homogenize/conduction.h"

namespace terrazzo::homogenize {

// The permeability tensor in mm² of the phases with open[phase], along the chosen axes: the mean velocity for
// a mean pressure gradient of 1 and a viscosity of 1. Velocities lie on the faces of voxels (Harlow and Welch
// 1965), and vanish on the walls, which are the faces of voxels that are not open. Fixed: a given pressure on
// two opposite faces, to which the velocity is normal, and walls on the others. By MINRES; the preconditioner
// is a V-cycle for each component of the velocity, and for the pressure the sum of the identity, which is
// right within pores, and of some W-cycles of Darcy's law along them (after Cahouet and Chabard 1988). The
// residual is that of the preconditioned system. `potential` of the result is the pressure, less its mean
// slope, and `flow` the speed. Throws Error "not-converged", "too-large".
Solved permeate(const PhaseMap&, const std::vector<char>& open, Boundary,
                const std::array<bool, 3>& directions, const Accuracy&, std::uint64_t memory, const Work&);

}  // namespace terrazzo::homogenize
