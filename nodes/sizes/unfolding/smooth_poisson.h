// Densities from Poisson counts that are smooth except for a few jumps. The counts choose the
// smoothness and the jumps.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo::unfolding {

// Counts n ~ Poisson(A·exp(θ)). A is rows × bins, all elements ≥ 0.
struct SmoothPoissonProblem {
  Eigen::MatrixXd A;
  Eigen::VectorXd counts;  // ≥ 0
  Eigen::VectorXd place;   // increasing position of each bin on the unit interval, along which θ is smooth
  // Optional constraint: total·exp(θ) = known_total with a relative standard
  // deviation known_error. Empty: none.
  Eigen::VectorXd total;
  double known_total = 0, known_error = 0;
};

// One smoothness model (smooth_prior.h) and the maximum a posteriori densities under it.
struct SmoothPoissonFit {
  int order = 1;
  double strength = 0;
  std::vector<int> breaks;  // bins after which densities may jump
  Eigen::VectorXd theta;    // log of the expected number per bin
  double freedom = 0;       // number of parameters that the counts determine: the trace of the smoother
  double evidence = 0;      // log marginal likelihood (Laplace's approximation) plus log prior of the breaks
  double weight = 0;        // posterior probability among all fits, Σ = 1
};

// The fits over all orders, decades of strength and up to four breaks whose weight is 1e-4 or more, weighted
// by evidence. This is empirical Bayes (restricted maximum likelihood chooses the smoothing of splines in the
// same way; Wood 2011), with averaging instead of selection. The prior gives each further break a probability
// of one half and a uniform position. Breaks are added one at a time to the three most probable sets
// (Denison, Mallick and Smith 1998 sample them). Newton steps maximize the penalized likelihood; EM would
// reach the same maximum in thousands of steps (Green 1990). The counts must not be all zero. Above 120 bins
// breaks are not searched for, because that would take minutes.
std::vector<SmoothPoissonFit> smooth_poisson_fits(const SmoothPoissonProblem&, const Work&);

// Σ weight·exp(θ).
Eigen::VectorXd mean_density(const std::vector<SmoothPoissonFit>&);

// One draw for the intervals; returns exp(θ). `problem` holds resampled counts. The smoothing is one of
// the fits, drawn by weight, and the center of its prior is drawn too ("randomize, then optimize",
// Bardsley et al. 2014): in a linear model the draws are exactly those of the posterior, so that the
// intervals include what smoothing may hide. The strength is a hundredth of the fit's, because
// undersmoothing is the usual remedy for the bias of smooth estimates in their intervals (Hall 1992). The
// factor was chosen by measured coverage.
Eigen::VectorXd draw_density(const SmoothPoissonProblem& problem, const std::vector<SmoothPoissonFit>&,
                             Random&);

}  // namespace terrazzo::unfolding
