// Principal axes of a three-dimensional covariance matrix.
#pragma once

#include <Eigen/Eigenvalues>

#include "nodes/data/linear.h"

namespace terrazzo {

// Columns are sorted by decreasing variance. The largest component of each column is positive, since the
// solver's sign is arbitrary.
inline Mat3 principal_axes(const Eigen::SelfAdjointEigenSolver<Mat3>& solver) {
  Mat3 axes;
  for (int c = 0; c < 3; ++c) {
    const Vec3 axis = solver.eigenvectors().col(2 - c);
    Eigen::Index i;
    axis.cwiseAbs().maxCoeff(&i);
    axes.col(c) = axis[i] < 0 ? Vec3(-axis) : axis;
  }
  return axes;
}

}  // namespace terrazzo
