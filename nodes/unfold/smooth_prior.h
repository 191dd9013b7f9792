// How densities are expected to vary: smoothly, but for a few places where they may jump.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace terrazzo {

// A Gaussian prior of log densities θ in bins at rising places on the unit interval: within each piece
// between two breaks −½·strength·∫|θ⁽ᵒʳᵈᵉʳ⁾|², so that orders 1, 2, 3 let constants, exponentials and
// Gaussians pass, and each piece's level anywhere about `level`, which keeps the prior a proper one and
// pieces that hold nothing from drifting away. A break b lies between bins b and b + 1: sizes cut off by a
// sieve, or two sievings in one.
struct SmoothPrior {
  int order = 1;
  double strength = 0;
  std::vector<int> breaks;  // rising
  double level = 0;
  Eigen::MatrixXd D;          // one row per difference that crosses no break: |D·θ|² is the integral
  Eigen::VectorXd ridge;      // precision of each bin about `level`
  Eigen::MatrixXd precision;  // of θ
  double log_det = 0;         // of that
};

// Divided differences of an order (≥ 1) at `place`, scaled so that |D·θ|² = ∫|θ⁽ᵒʳᵈᵉʳ⁾|².
Eigen::MatrixXd roughness(int order, const Eigen::VectorXd& place);

// `differences`: roughness() of that order.
SmoothPrior smooth_prior(int order, const Eigen::MatrixXd& differences, double strength,
                         std::vector<int> breaks, double level);

}  // namespace terrazzo
