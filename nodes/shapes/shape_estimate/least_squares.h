// Nonlinear least squares without derivatives.
#pragma once

#include <Eigen/Dense>
#include <functional>

#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct LeastSquaresOptions {
  int rounds = 10;
  double step = 0.2;  // of the finite differences, in the units of the variables
  int updates = 2;  // further moves of each round, with slopes updated instead of differenced (Broyden 1965)
  double ridge = 0.02;  // adds ridge²·‖x‖² to the sum of squares
};

struct LeastSquares {
  Eigen::VectorXd x;
  double value = 0;       // sum of squares including the ridge
  Eigen::MatrixXd slope;  // of the residuals at x, about
};

// Levenberg–Marquardt (Marquardt 1963) on forward differences, from `start`. Each round uses the best of
// several dampings. If none improves, it reverses and halves the differences; it ends after two such rounds
// in a row. `slope`: that at the start, if it is known, about; else the first round differences, too.
// `residuals` is called from several threads concurrently and may return an empty vector if x is
// infeasible, except at the start. The result does not depend on the number of threads.
LeastSquares least_squares(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
                           const Eigen::VectorXd& start, const LeastSquaresOptions&, const Work& = {},
                           Eigen::MatrixXd slope = {});

}  // namespace terrazzo::shape_estimate
