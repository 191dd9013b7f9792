#include "nodes/shapes/shape_estimate/least_squares.h"

#include <array>
#include <limits>
#include <vector>

namespace terrazzo::shape_estimate {

constexpr double kLittle = 0.98;  // less progress than this calls for new finite differences

namespace {

using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

// Finite differences from `start`, where the residuals are `at`; backward where the forward ones fail.
Eigen::MatrixXd slopes_at(const Residuals& residuals, const Eigen::VectorXd& start, const Eigen::VectorXd& at,
                          double step, const Work& work) {
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(at.size(), start.size());
  work.parallel(start.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Eigen::Index c = k;
      for (const double h : {step, -step}) {
        Eigen::VectorXd x = start;
        x[c] += h;
        const Eigen::VectorXd r = residuals(x);
        if (!r.size()) continue;
        slope.col(c) = (r - at) / h;
        break;
      }
    }
  });
  return slope;
}

}  // namespace

LeastSquares least_squares(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
                           const Eigen::VectorXd& start, const LeastSquaresOptions& o, const Work& work,
                           Eigen::MatrixXd slope) {
  const double ridge = o.ridge * o.ridge;
  const auto total = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& r) {
    return r.size() ? r.squaredNorm() + ridge * x.squaredNorm() : std::numeric_limits<double>::infinity();
  };
  const auto n = start.size();
  LeastSquares best{start, 0, {}};
  Eigen::VectorXd at = residuals(start);
  best.value = total(start, at);
  double damping = 0.1, step = o.step;
  int failures = 0;
  for (int round = 0; round < o.rounds; ++round) {
    work.check();
    const bool known = round == 0 && slope.size() > 0;
    if (!known) slope = slopes_at(residuals, best.x, at, step, work.quiet());
    bool improved = false;
    for (int move = 0; move <= o.updates; ++move) {
      const Eigen::MatrixXd square = slope.transpose() * slope;
      const Eigen::VectorXd fall = -(slope.transpose() * at + ridge * best.x);
      constexpr std::array<double, 6> kDampings{0.01, 0.1, 1, 10, 100, 1000};
      std::array<LeastSquares, kDampings.size()> tries;
      std::array<Eigen::VectorXd, kDampings.size()> reached;
      const double level = square.trace() / n;
      work.quiet().parallel(tries.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          Eigen::MatrixXd m = square;
          m.diagonal().array() += ridge + damping * kDampings[k] * level;
          Eigen::VectorXd x = m.ldlt().solve(fall);
          // Limit the step to where the finite differences are valid.
          const double most = 10 * o.step, far = x.norm();
          if (far > most) x *= most / far;
          tries[k].x = best.x + x;
          reached[k] = residuals(tries[k].x);
          tries[k].value = total(tries[k].x, reached[k]);
        }
      });
      std::size_t chosen = 0;
      for (std::size_t k = 1; k < tries.size(); ++k)
        if (tries[k].value < tries[chosen].value) chosen = k;
      if (!(tries[chosen].value < best.value)) break;
      const bool little = tries[chosen].value > kLittle * best.value;
      const Eigen::VectorXd x = tries[chosen].x - best.x;
      const Eigen::VectorXd r = reached[chosen] - at;
      slope += (r - slope * x) * x.transpose() / x.squaredNorm();
      best = tries[chosen];
      at = reached[chosen];
      damping = std::min(10.0, std::max(1e-4, damping * kDampings[chosen]));
      improved = true;
      if (little) break;
    }
    work.progress((round + 1.0) / o.rounds);
    if (improved) {
      failures = 0;
      continue;
    }
    if (known) continue;
    if (++failures == 2) break;
    step = -step / 2;
  }
  best.slope = std::move(slope);
  return best;
}

}  // namespace terrazzo::shape_estimate
