#include "nodes/compare/texture_observer/ridge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/geometry/mesh/principal_axes.h"

namespace terrazzo::texture_observer {

namespace {

struct Spectrum {
  Eigen::MatrixXd u;  // left singular vectors of the examples
  Eigen::ArrayXd s2;  // squared singular values
};

Spectrum spectrum_of(const Eigen::MatrixXd& x) {
  const bool few = x.rows() <= x.cols();
  const auto axes = eigen_axes(few ? Eigen::MatrixXd(x * x.transpose()) : Eigen::MatrixXd(x.transpose() * x));
  const double least = 1e-10 * std::max(axes.eigenvalues().maxCoeff(), 1e-300);
  const auto kept = (axes.eigenvalues().array() > least).count();
  Spectrum out;
  out.s2 = axes.eigenvalues().tail(kept).array();  // in increasing order
  out.u = axes.eigenvectors().rightCols(kept);
  if (!few) out.u = x * out.u * out.s2.rsqrt().matrix().asDiagonal();
  return out;
}

// Mean squared error of each strip, predicted from the others: the residual of a left-out block is
// (1 − H)⁻¹ times its residual with everything in, where H is the block of the hat matrix.
double error_without(const Spectrum& a, const Eigen::VectorXd& y, const std::vector<int>& strip,
                     double penalty) {
  const Eigen::ArrayXd shrink = a.s2 / (a.s2 + penalty);
  const Eigen::VectorXd residual = y - a.u * (shrink.matrix().asDiagonal() * (a.u.transpose() * y));
  double error = 0;
  for (int block = 0; block <= *std::max_element(strip.begin(), strip.end()); ++block) {
    std::vector<Eigen::Index> rows;
    for (std::size_t i = 0; i < strip.size(); ++i)
      if (strip[i] == block) rows.push_back(i);
    if (rows.empty()) continue;
    const Eigen::MatrixXd u = a.u(rows, Eigen::all);
    Eigen::MatrixXd rest = -u * shrink.matrix().asDiagonal() * u.transpose();
    rest.array() -= 1.0 / y.size();  // the mean is learned, too
    rest.diagonal().array() += 1;
    error += rest.ldlt().solve(Eigen::VectorXd(residual(rows))).squaredNorm();
  }
  return error / y.size();
}

}  // namespace

Ridge::Ridge(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const std::vector<int>& strip,
             const Work& work) {
  const double n = x.rows();
  mean_ = x.colwise().mean();
  Eigen::MatrixXd z = x.rowwise() - mean_;
  scale_ = (z.colwise().squaredNorm() / n).array().sqrt();
  for (Eigen::Index k = 0; k < scale_.size(); ++k)  // features that never vary are ignored
    scale_[k] = scale_[k] > 1e-9 * (1 + std::abs(mean_[k])) ? 1 / scale_[k] : 0;
  z = z * scale_.asDiagonal();
  work.check();
  const Spectrum spectrum = spectrum_of(z);
  double best = n, least = std::numeric_limits<double>::infinity();
  const bool blocks = std::any_of(strip.begin(), strip.end(), [&](int s) { return s != strip.front(); });
  for (double penalty : {1e2, 1e1, 1e0, 1e-1, 1e-2, 1e-3, 1e-4}) {
    if (!blocks) break;  // nothing to predict a strip from
    work.check();
    const double error = error_without(spectrum, y, strip, n * penalty);
    if (error < least) {
      least = error;
      best = n * penalty;
    }
  }
  const Eigen::VectorXd along =
      (spectrum.u.transpose() * y).array() / (spectrum.s2 + best);  // XᵀU (S² + λ)⁻¹ Uᵀ y
  weights_ = z.transpose() * (spectrum.u * along);
}

Eigen::VectorXd Ridge::scores(const Eigen::MatrixXd& x) const {
  return (x.rowwise() - mean_) * scale_.asDiagonal() * weights_;
}

}  // namespace terrazzo::texture_observer
