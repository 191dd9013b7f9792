// Densities that vary smoothly but for a few jumps, from Poisson counts, with the smoothness and the jumps
// chosen by the counts themselves.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo {

// Counts n ~ Poisson(A·exp(θ)), rows × bins, all A ≥ 0.
struct SmoothPoissonProblem {
  Eigen::MatrixXd A;
  Eigen::VectorXd counts;  // ≥ 0
  Eigen::VectorXd place;   // of each bin on the unit interval on which θ is smooth, rising
  // What total·exp(θ) is known to be, and how well (relative, one standard deviation). Empty: nothing known.
  Eigen::VectorXd total;
  double known_total = 0, known_error = 0;
};

// One way to be smooth (smooth_prior.h) and the densities of highest posterior density under it.
struct SmoothPoissonFit {
  int order = 1;
  double strength = 0;
  std::vector<int> breaks;  // bins after which densities may jump
  Eigen::VectorXd theta;    // log of the expected number per bin
  double freedom = 0;       // parameters that the counts determine: the trace of the smoother
  double evidence = 0;      // log marginal likelihood (Laplace's approximation) and prior of the breaks
  double weight = 0;        // its share among all, Σ = 1
};

// Fits over all orders, decades of strength and up to four breaks that have a weight of 1e-4 or more,
// weighted by evidence: empirical Bayes (as restricted maximum likelihood chooses the smoothing of splines;
// Wood 2011), averaged rather than chosen. One more break is as likely as none, and may be anywhere; they are
// searched for one by one from the three likeliest sets (as Denison, Mallick and Smith 1998 sample them).
// Newton steps on the penalised likelihood, which EM reaches too but in thousands of steps (Green 1990).
// Counts must not be all zero. More than 120 bins: no breaks, which would take minutes.
std::vector<SmoothPoissonFit> smooth_poisson_fits(const SmoothPoissonProblem&, const Work&);

// Σ weight·exp(θ).
Eigen::VectorXd mean_density(const std::vector<SmoothPoissonFit>&);

// One draw for intervals: `problem` holds counts drawn again; the smoothing is one of the fits, by weight,
// and its prior's centre is drawn too ("randomise, then optimise", Bardsley et al. 2014: for a linear model
// the draws are exactly the posterior's, so that what smoothing may hide counts among the errors). The
// strength is a hundredth of the fit's, as undersmoothing is the usual remedy for the bias of smooth
// estimates in their intervals (Hall 1992); the factor was set by measured coverage. Returns exp(θ).
Eigen::VectorXd draw_density(const SmoothPoissonProblem& problem, const std::vector<SmoothPoissonFit>&,
                             Random&);

}  // namespace terrazzo
