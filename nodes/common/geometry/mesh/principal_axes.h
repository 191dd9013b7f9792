// Axes of symmetric matrices, such as covariances.
#pragma once

#include <Eigen/Eigenvalues>

#include "nodes/data/linear.h"

namespace terrazzo {

// Eigenvalues in increasing order, and eigenvectors. Eigen's solvers take seconds to compile, here only once.
Eigen::SelfAdjointEigenSolver<Mat3> eigen_axes(const Mat3& symmetric);
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_axes(const Eigen::MatrixXd& symmetric);
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> eigen_axes(const Eigen::MatrixXf& symmetric);

// Columns are sorted by decreasing variance. The largest component of each column is positive, since the
// solver's sign is arbitrary.
Mat3 principal_axes(const Eigen::SelfAdjointEigenSolver<Mat3>& solver);

}  // namespace terrazzo
