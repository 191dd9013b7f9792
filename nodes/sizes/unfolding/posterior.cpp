#include "nodes/sizes/unfolding/posterior.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace terrazzo::unfolding {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kTiny = 1e-12;     // lower bound of expected counts
constexpr double kLargestStep = 3;  // largest change of a log density per Newton step

}  // namespace

Posterior::Posterior(const SmoothPoissonProblem& p, const SmoothPrior& prior, const VectorXd* shift,
                     const VectorXd* off)
    : p_(p), prior_(prior), shift_(shift), off_(off) {}

VectorXd Posterior::rough(const VectorXd& theta) const {
  VectorXd v = prior_.D * theta;
  if (shift_) v -= *shift_;
  return v;
}

VectorXd Posterior::away(const VectorXd& theta) const {
  VectorXd v = theta.array() - prior_.level;
  if (off_) v -= *off_;
  return v;
}

double Posterior::value(const VectorXd& theta, VectorXd& x, VectorXd& mu) const {
  x = theta.array().exp();
  mu = (p_.A * x).cwiseMax(kTiny);
  double sum = (p_.counts.array() * mu.array().log()).sum() - mu.sum();
  if (p_.total.size() > 0) {
    const double miss = (p_.total.dot(x) - p_.known_total) / (p_.known_error * p_.known_total);
    sum -= miss * miss / 2;
  }
  return sum - prior_.strength * rough(theta).squaredNorm() / 2 -
         (prior_.ridge.array() * away(theta).array().square()).sum() / 2;
}

void Posterior::slopes(const VectorXd& theta, const VectorXd& x, const VectorXd& mu, VectorXd& gradient,
                       MatrixXd& information) const {
  const VectorXd root = mu.cwiseSqrt();
  const MatrixXd J = root.cwiseInverse().asDiagonal() * p_.A * x.asDiagonal();
  gradient = J.transpose() * (p_.counts - mu).cwiseQuotient(root);
  information = prior_.precision;
  information.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
  if (p_.total.size() > 0) {
    const double error = p_.known_error * p_.known_total;
    const VectorXd v = p_.total.cwiseProduct(x) / error;
    gradient -= (p_.total.dot(x) - p_.known_total) / error * v;
    information.selfadjointView<Eigen::Lower>().rankUpdate(v);
  }
  gradient -=
      prior_.strength * (prior_.D.transpose() * rough(theta)) + prior_.ridge.cwiseProduct(away(theta));
}

double climb(const Posterior& f, VectorXd& theta, MatrixXd& information, double enough) {
  VectorXd x, mu, gradient, next_x, next_mu;
  double value = f.value(theta, x, mu), damping = 0;
  for (int step = 0; step < 60; ++step) {
    f.slopes(theta, x, mu, gradient, information);
    double gain = -1;
    for (int attempt = 0; attempt < 12 && gain < 0; ++attempt) {
      MatrixXd damped = information;
      damped.diagonal().array() += damping;
      VectorXd move = damped.llt().solve(gradient);
      if (const double most = move.cwiseAbs().maxCoeff(); most > kLargestStep) move *= kLargestStep / most;
      const VectorXd next = theta + move;
      const double there = f.value(next, next_x, next_mu);
      if (there >= value - 1e-12) {
        gain = std::max(0.0, there - value);
        theta = next;
        x.swap(next_x);
        mu.swap(next_mu);
        value = there;
        damping = damping > 1e-9 ? damping / 10 : 0;
      } else {
        damping = damping > 0 ? 10 * damping : 0.01 * information.diagonal().maxCoeff();
      }
    }
    if (gain < enough) break;
  }
  f.slopes(theta, x, mu, gradient, information);
  return value;
}

double even_level(const SmoothPoissonProblem& p) {
  return std::log(std::max(p.counts.sum(), kTiny) / std::max(p.A.sum(), 1e-300));
}

}  // namespace terrazzo::unfolding
