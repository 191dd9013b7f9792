#include "nodes/sizes/unfolding/poisson_fit.h"

#include <cmath>

namespace terrazzo::unfolding {

PoissonFit poisson_fit(const Eigen::MatrixXd& A, const Eigen::VectorXd& counts, int iterations) {
  const Eigen::VectorXd exposure = A.colwise().sum().transpose();
  PoissonFit fit;
  fit.x = Eigen::VectorXd::Constant(A.cols(), exposure.sum() > 0 ? counts.sum() / exposure.sum() : 0);
  Eigen::VectorXd expected = A * fit.x;
  for (int k = 0; k < iterations; ++k) {
    const Eigen::VectorXd ratio =
        (expected.array() > 0)
            .select(counts.array() / expected.array().max(1e-300), Eigen::ArrayXd::Zero(counts.size()));
    const Eigen::VectorXd factor = A.transpose() * ratio;
    for (Eigen::Index j = 0; j < fit.x.size(); ++j) fit.x[j] *= exposure[j] > 0 ? factor[j] / exposure[j] : 0;
    expected = A * fit.x;
  }
  for (Eigen::Index i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) fit.log_likelihood += counts[i] * std::log(std::max(expected[i], 1e-300));
    fit.log_likelihood -= expected[i];
  }
  return fit;
}

}  // namespace terrazzo::unfolding
