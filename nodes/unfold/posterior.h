// The densities of highest posterior density under one smooth prior.
#pragma once

#include <Eigen/Core>

#include "nodes/unfold/smooth_poisson.h"
#include "nodes/unfold/smooth_prior.h"

namespace terrazzo {

// Log likelihood and log prior (without constants), their slope and Fisher's information. The prior's centre
// may be moved: `shift` of D·θ, `off` of θ itself.
class Posterior {
 public:
  Posterior(const SmoothPoissonProblem&, const SmoothPrior&, const Eigen::VectorXd* shift = nullptr,
            const Eigen::VectorXd* off = nullptr);

  // The value at theta; x = exp(θ) and the expected counts mu beside it.
  double value(const Eigen::VectorXd& theta, Eigen::VectorXd& x, Eigen::VectorXd& mu) const;
  // `information`: its lower half.
  void slopes(const Eigen::VectorXd& theta, const Eigen::VectorXd& x, const Eigen::VectorXd& mu,
              Eigen::VectorXd& gradient, Eigen::MatrixXd& information) const;

 private:
  Eigen::VectorXd rough(const Eigen::VectorXd& theta) const;
  Eigen::VectorXd away(const Eigen::VectorXd& theta) const;

  const SmoothPoissonProblem& p_;
  const SmoothPrior& prior_;
  const Eigen::VectorXd *shift_, *off_;
};

// Newton's method, damped after Levenberg, from theta to the top, until a step gains less than `enough`;
// returns the value there. `information`: its lower half.
double climb(const Posterior&, Eigen::VectorXd& theta, Eigen::MatrixXd& information, double enough);

// Even log densities that explain the number of counts.
double even_level(const SmoothPoissonProblem&);

}  // namespace terrazzo
