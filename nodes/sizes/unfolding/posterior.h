// The maximum a posteriori densities under one smooth prior.
#pragma once

#include <Eigen/Core>

#include "nodes/sizes/unfolding/smooth_poisson.h"
#include "nodes/sizes/unfolding/smooth_prior.h"

namespace terrazzo::unfolding {

// Log likelihood plus log prior (without constants), their gradient and the Fisher information. The center of
// the prior can be moved: `shift` moves that of D·θ, `off` that of θ.
class Posterior {
 public:
  Posterior(const SmoothPoissonProblem&, const SmoothPrior&, const Eigen::VectorXd* shift = nullptr,
            const Eigen::VectorXd* off = nullptr);

  // The value at theta. Also returns x = exp(θ) and the expected counts mu.
  double value(const Eigen::VectorXd& theta, Eigen::VectorXd& x, Eigen::VectorXd& mu) const;
  // Gradient and information at theta; only the lower half of `information` is set.
  void slopes(const Eigen::VectorXd& theta, const Eigen::VectorXd& x, const Eigen::VectorXd& mu,
              Eigen::VectorXd& gradient, Eigen::MatrixXd& information) const;

 private:
  Eigen::VectorXd rough(const Eigen::VectorXd& theta) const;
  Eigen::VectorXd away(const Eigen::VectorXd& theta) const;

  const SmoothPoissonProblem& p_;
  const SmoothPrior& prior_;
  const Eigen::VectorXd *shift_, *off_;
};

// Maximizes the posterior from theta with Newton's method and Levenberg damping, until a step gains less than
// `enough`. Returns the value at the maximum; only the lower half of `information` is set.
double climb(const Posterior&, Eigen::VectorXd& theta, Eigen::MatrixXd& information, double enough);

// The constant log density whose expected total equals the number of counts.
double even_level(const SmoothPoissonProblem&);

}  // namespace terrazzo::unfolding
