// Prior on densities: smooth, except for a few places where they may jump.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace terrazzo::unfolding {

// A Gaussian prior on log densities θ in bins at increasing places on the unit interval. Within each piece
// between two breaks its log is −½·strength·∫|θ⁽ᵒʳᵈᵉʳ⁾|², so that orders 1, 2, 3 leave constants,
// exponentials and Gaussians unpenalized. The level of each piece has a wide prior about `level`, which makes
// the prior proper and keeps empty pieces from drifting away. A break b lies between bins b and b + 1; it
// models sizes cut off by a sieve, or a mix of two sievings.
struct SmoothPrior {
  int order = 1;
  double strength = 0;
  std::vector<int> breaks;  // increasing
  double level = 0;
  Eigen::MatrixXd D;          // one row per difference that crosses no break: |D·θ|² is the integral
  Eigen::VectorXd ridge;      // precision of each bin about `level`
  Eigen::MatrixXd precision;  // total precision of θ
  double log_det = 0;         // log determinant of `precision`
};

// Divided differences of order `order` (≥ 1) at `place`, scaled so that |D·θ|² = ∫|θ⁽ᵒʳᵈᵉʳ⁾|².
Eigen::MatrixXd roughness(int order, const Eigen::VectorXd& place);

// `differences` is roughness() of the same order.
SmoothPrior smooth_prior(int order, const Eigen::MatrixXd& differences, double strength,
                         std::vector<int> breaks, double level);

}  // namespace terrazzo::unfolding
