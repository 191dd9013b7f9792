// Maximum likelihood of Poisson counts by expectation–maximization.
#pragma once

#include <Eigen/Core>

namespace terrazzo::unfolding {

struct PoissonFit {
  Eigen::VectorXd x;          // ≥ 0
  double log_likelihood = 0;  // Σ n·log μ − μ, without the constant Σ log n!
};

// The x ≥ 0 that maximizes the likelihood of counts n ~ Poisson(μ), μ = A·x, by the Richardson–Lucy iteration
// (Silverman et al. 1990) from a uniform start. A ≥ 0: rows × columns; counts ≥ 0.
PoissonFit poisson_fit(const Eigen::MatrixXd& A, const Eigen::VectorXd& counts, int iterations);

}  // namespace terrazzo::unfolding
