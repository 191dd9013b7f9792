#include "nodes/sizes/unfolding/smooth_prior.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace terrazzo::unfolding {
namespace {

constexpr double kSpread = 5;  // standard deviation of a piece's mean log density: a factor of 150 up or down

}  // namespace

Eigen::MatrixXd roughness(int order, const Eigen::VectorXd& place) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Identity(place.size(), place.size());
  Eigen::VectorXd at = place, step;
  for (int k = 0; k < order; ++k) {
    const Eigen::Index rows = D.rows() - 1;
    step = at.tail(rows) - at.head(rows);
    Eigen::MatrixXd next = step.cwiseInverse().asDiagonal() * (D.bottomRows(rows) - D.topRows(rows));
    D = std::move(next);
    at = ((at.tail(rows) + at.head(rows)) / 2).eval();
  }
  return step.cwiseSqrt().asDiagonal() * D;
}

SmoothPrior smooth_prior(int order, const Eigen::MatrixXd& differences, double strength,
                         std::vector<int> breaks, double level) {
  SmoothPrior p;
  p.order = order;
  p.strength = strength;
  p.level = level;
  const int bins = differences.cols();
  p.D.resize(differences.rows(), bins);
  Eigen::Index rows = 0;
  for (int i = 0; i < differences.rows(); ++i)
    if (std::none_of(breaks.begin(), breaks.end(), [&](int b) { return b >= i && b < i + order; }))
      p.D.row(rows++) = differences.row(i);
  p.D.conservativeResize(rows, bins);

  p.ridge.resize(bins);
  int from = 0;
  for (std::size_t k = 0; k <= breaks.size(); ++k) {
    const int to = k < breaks.size() ? breaks[k] + 1 : bins;
    p.ridge.segment(from, to - from).setConstant(1 / (kSpread * kSpread * (to - from)));
    from = to;
  }
  p.precision = strength * (p.D.transpose() * p.D);
  p.precision.diagonal() += p.ridge;
  const Eigen::LLT<Eigen::MatrixXd> factor(p.precision);
  for (Eigen::Index i = 0; i < bins; ++i) p.log_det += 2 * std::log(factor.matrixLLT()(i, i));
  p.breaks = std::move(breaks);
  return p;
}

}  // namespace terrazzo::unfolding
