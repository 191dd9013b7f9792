// Maximum likelihood of Poisson counts by expectation–maximisation.
#pragma once

#include <Eigen/Core>

namespace terrazzo {

struct PoissonFit {
  Eigen::VectorXd x;          // ≥ 0
  double log_likelihood = 0;  // Σ n·log μ − μ, without the constant log n!
};

// x ≥ 0 with μ = A·x and counts n ~ Poisson(μ), by Richardson and Lucy's iteration (Silverman et al. 1990)
// from an even start. A ≥ 0: rows × columns; counts ≥ 0.
PoissonFit poisson_fit(const Eigen::MatrixXd& A, const Eigen::VectorXd& counts, int iterations);

}  // namespace terrazzo
