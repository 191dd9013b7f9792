// Nonlinear least squares without derivatives.
#pragma once

#include <Eigen/Dense>
#include <functional>

#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct LeastSquaresOptions {
  int rounds = 10;
  double step = 0.2;    // of the differences that stand for derivatives, in the variables' units
  double ridge = 0.02;  // added to the sum of squares: ridge²·‖x‖²
};

struct LeastSquares {
  Eigen::VectorXd x;
  double value = 0;  // sum of squares with the ridge
};

// Levenberg–Marquardt (Marquardt 1963) on forward differences, from `start`: each round takes the best of
// several dampings, and turns the differences round where none is better; ends after two such rounds.
// `residuals` is called from several threads at once and may give an empty vector where x makes nothing; it
// must not be empty at the start. The same for any number of threads.
LeastSquares least_squares(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
                           const Eigen::VectorXd& start, const LeastSquaresOptions&, const Work& = {});

}  // namespace terrazzo::shape_estimate
