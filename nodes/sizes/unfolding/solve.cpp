#include "nodes/sizes/unfolding/solve.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "graph/diagnostic.h"
#include "nodes/sizes/unfolding/nnls.h"

namespace terrazzo::unfolding {

Eigen::VectorXd solve_inverse(const UnfoldModel& m, const Eigen::VectorXd& profile_density) {
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(m.matrix);
  if (!lu.isInvertible())
    throw Error("singular", "the K matrix of the visible classes is singular",
                "use fewer classes, a smaller smallest_visible, or method: em")
        .parameter("method");
  return lu.solve(profile_density);
}

Eigen::VectorXd solve_nnls(const UnfoldModel& m, const Counts& counts, double area, double area_fraction,
                           double area_error) {
  const Eigen::Index n = counts.sum.size();
  const Eigen::Index rows = n + (area_fraction > 0 ? 1 : 0);
  // A class without profiles still has the counting error of about one profile of mean weight.
  const double total = counts.sum.sum();
  const double one = total > 0 ? counts.squares.sum() / total : 1;
  Eigen::MatrixXd A(rows, n);
  Eigen::VectorXd b(rows);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double error = std::sqrt(counts.squares[i] + one * one) / area;
    A.row(i) = m.matrix.row(i) / error;
    b[i] = counts.sum[i] / area / error;
  }
  if (area_fraction > 0) {
    const double error = area_error * area_fraction;
    A.row(n) = m.volume.transpose() / error;
    b[n] = area_fraction / error;
  }
  // Columns differ by orders of magnitude (a large particle weighs a thousand small ones): scale
  // them to unit length.
  const Eigen::VectorXd length = A.colwise().norm().transpose();
  for (Eigen::Index j = 0; j < n; ++j) A.col(j) /= length[j];
  return nnls(A, b).cwiseQuotient(length);
}

double condition_of(Eigen::MatrixXd m) {
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    if (const double length = m.col(j).norm(); length > 0) m.col(j) /= length;
  const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(m).singularValues();
  return s[s.size() - 1] > 0 ? s[0] / s[s.size() - 1] : std::numeric_limits<double>::infinity();
}

}  // namespace terrazzo::unfolding
