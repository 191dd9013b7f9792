// Effective stiffness of a periodic voxel model: ∇·(C : ε) = 0.
#pragma once

#include <array>
#include <vector>

#include "nodes/properties/homogenize/convergence.h"
#include "nodes/properties/homogenize/phases.h"

namespace terrazzo::homogenize {

// Isotropic. Young's modulus ≥ 0, of which 0 is a pore; Poisson's ratio above −1 and below 0.5.
struct Elastic {
  double young = 0, poisson = 0;
  double lambda() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
  double mu() const { return young / (2 * (1 + poisson)); }
};

using Stiffness =
    Eigen::Matrix<double, 6, 6>;  // Voigt: xx, yy, zz, yz, xz, xy, with engineering shear strains

struct SolvedStiffness {
  Stiffness effective = Stiffness::Zero();
  int iterations = 0;         // most of any load
  double residual = 0;        // largest of any load, of the final forces
  std::vector<float> stress;  // von Mises stress at the centers of voxels, for a mean strain xx of 1
};

// Bytes for this many voxels.
double elasticity_bytes(double voxels);

// The stiffness of a map of cubic voxels whose phases have `values`. Each voxel is a trilinear finite
// element, integrated exactly, so that the result is an upper bound for the voxel model. By conjugate
// gradients for the displacements; the preconditioner is the inverse of a homogeneous medium by Fourier
// transform (Moulinec and Suquet 1998; Leute et al. 2022), which needs about as many iterations for pores as
// for a contrast of 100. Throws Error "not-cubic", "not-converged", "too-large".
SolvedStiffness stiffness(const PhaseMap&, const std::vector<Elastic>& values, const Accuracy&,
                          std::uint64_t memory, const Work&);

}  // namespace terrazzo::homogenize
