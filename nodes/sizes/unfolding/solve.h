// The two direct solutions of N_A = M·N_V.
#pragma once

#include <Eigen/Core>

#include "nodes/sizes/unfolding/model.h"

namespace terrazzo::unfolding {

// M⁻¹·N_A, with any negative densities (Jagnow et al. 2004, eq. 8 and 12). Throws Error "singular".
Eigen::VectorXd solve_inverse(const UnfoldModel&, const Eigen::VectorXd& profile_density);

// The densities ≥ 0 with the least squared error, each class weighted by the counting error of its profiles,
// plus one row: Σ N_V·V = area fraction, with the relative error `area_error` (V_V = A_A). Area fraction 0:
// unknown, no such row.
Eigen::VectorXd solve_nnls(const UnfoldModel&, const Counts&, double area, double area_fraction,
                           double area_error);

// Condition number of the matrix after scaling its columns to unit length.
double condition_of(Eigen::MatrixXd);

}  // namespace terrazzo::unfolding
