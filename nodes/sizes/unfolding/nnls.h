// Nonnegative least squares.
#pragma once

#include <Eigen/Core>

namespace terrazzo::unfolding {

// The x ≥ 0 that minimizes |A·x − b|² (Lawson and Hanson 1974, chapter 23). A: rows × columns, rows ≥ 1.
Eigen::VectorXd nnls(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace terrazzo::unfolding
