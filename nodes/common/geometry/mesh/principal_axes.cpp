#include "nodes/common/geometry/mesh/principal_axes.h"

namespace terrazzo {

Eigen::SelfAdjointEigenSolver<Mat3> eigen_axes(const Mat3& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Mat3>(symmetric);
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_axes(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric);
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> eigen_axes(const Eigen::MatrixXf& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf>(symmetric);
}

Mat3 principal_axes(const Eigen::SelfAdjointEigenSolver<Mat3>& solver) {
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
