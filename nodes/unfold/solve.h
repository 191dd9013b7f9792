// The two direct solutions of N_A = M·N_V.
#pragma once

#include <Eigen/Core>

#include "nodes/unfold/model.h"

namespace terrazzo {

// M⁻¹·N_A, negative densities and all (Jagnow et al. 2004, eq. 8 and 12). Throws Error "singular".
Eigen::VectorXd solve_inverse(const UnfoldModel&, const Eigen::VectorXd& profile_density);

// Densities ≥ 0 of least squared error, each class weighted by the counting error of its profiles, with one
// row more: Σ N_V·V = area fraction within `area_error`, relative (V_V = A_A). Area fraction 0: unknown, no
// such row.
Eigen::VectorXd solve_nnls(const UnfoldModel&, const Counts&, double area, double area_fraction,
                           double area_error);

// Of the model matrix, columns scaled to length one.
double condition_of(Eigen::MatrixXd);

}  // namespace terrazzo
