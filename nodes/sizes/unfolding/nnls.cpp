#include "nodes/sizes/unfolding/nnls.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <Eigen/QR>

namespace terrazzo::unfolding {

Eigen::VectorXd nnls(const Eigen::MatrixXd& A_in, const Eigen::VectorXd& b) {
  const Eigen::Index n = A_in.cols();
  // Scale columns to unit length, so that the test for entering the free set does not depend on units.
  Eigen::VectorXd scale = A_in.colwise().norm().transpose();
  for (auto& s : scale) s = s > 0 ? s : 1;
  const Eigen::MatrixXd A = A_in * scale.cwiseInverse().asDiagonal();
  const double tolerance = 1e-12 * std::max(b.norm(), std::numeric_limits<double>::min());

  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<char> free(n, 0);
  const auto solve_free = [&] {
    std::vector<Eigen::Index> columns;
    for (Eigen::Index j = 0; j < n; ++j)
      if (free[j]) columns.push_back(j);
    Eigen::MatrixXd F(A.rows(), columns.size());
    for (std::size_t k = 0; k < columns.size(); ++k) F.col(k) = A.col(columns[k]);
    const Eigen::VectorXd y = F.colPivHouseholderQr().solve(b);
    Eigen::VectorXd z = Eigen::VectorXd::Zero(n);
    for (std::size_t k = 0; k < columns.size(); ++k) z[columns[k]] = y[k];
    return z;
  };

  // Each round frees one column, and the inner loop binds those that would turn negative. The residual falls
  // every round, so the loop terminates; the bound guards against rounding.
  for (Eigen::Index round = 0; round < 10 * n + 10; ++round) {
    const Eigen::VectorXd gradient = A.transpose() * (b - A * x);
    Eigen::Index enter = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (!free[j] && gradient[j] > tolerance && (enter < 0 || gradient[j] > gradient[enter])) enter = j;
    if (enter < 0) break;
    free[enter] = 1;
    for (;;) {
      const Eigen::VectorXd z = solve_free();
      double step = 1;
      Eigen::Index leave = -1;
      for (Eigen::Index j = 0; j < n; ++j) {
        if (!free[j] || z[j] > 0) continue;
        const double s = x[j] > 0 ? x[j] / (x[j] - z[j]) : 0;
        if (leave < 0 || s < step) {
          step = s;
          leave = j;
        }
      }
      if (leave < 0) {
        x = z;
        break;
      }
      x += step * (z - x);
      x[leave] = 0;
      free[leave] = 0;
      for (Eigen::Index j = 0; j < n; ++j)
        if (free[j] && x[j] < 0) x[j] = 0;
    }
  }
  return x.cwiseMax(0).cwiseQuotient(scale);
}

}  // namespace terrazzo::unfolding
