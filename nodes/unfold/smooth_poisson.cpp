#include "nodes/unfold/smooth_poisson.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace terrazzo {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRidge = 1e-6;  // keeps bins that no count reaches from drifting away
constexpr double kVague = 10;  // standard deviation that an unpenalised direction counts with in the evidence
constexpr double kTiny = 1e-12;     // least expected count
constexpr double kLargestStep = 3;  // of log densities, per Newton step
constexpr double kRougher =
    0.01;  // strength in draws: intervals leave out the bias of smoothing only if it is less
constexpr double kGiveUp = 25;  // log evidence below the best at which a series of strengths ends

double log_determinant(const Eigen::LLT<MatrixXd>& l) {
  double sum = 0;
  for (Eigen::Index i = 0; i < l.matrixLLT().rows(); ++i) sum += std::log(l.matrixLLT()(i, i));
  return 2 * sum;
}

// Divided differences of an order, scaled so that |D·θ|² = ∫|θ⁽ᵒʳᵈᵉʳ⁾|² over the unit interval.
struct Roughness {
  int order;
  MatrixXd D, penalty;
  Roughness(int order, const VectorXd& place) : order(order) {
    const Eigen::Index bins = place.size();
    D = MatrixXd::Identity(bins, bins);
    VectorXd at = place, step;
    for (int k = 0; k < order; ++k) {
      const Eigen::Index rows = D.rows() - 1;
      step = at.tail(rows) - at.head(rows);
      MatrixXd next = step.cwiseInverse().asDiagonal() * (D.bottomRows(rows) - D.topRows(rows));
      D = std::move(next);
      at = ((at.tail(rows) + at.head(rows)) / 2).eval();
    }
    D = (step.cwiseSqrt().asDiagonal() * D).eval();
    penalty = D.transpose() * D;
  }
  // Of the penalty, without its null space.
  double log_det() const { return log_determinant(Eigen::LLT<MatrixXd>(D * D.transpose())); }
};

// The penalised log likelihood, its slope and Fisher's information at a point.
class Posterior {
 public:
  Posterior(const SmoothPoissonProblem& p, const Roughness& r, double strength, const VectorXd* shift)
      : p_(p), r_(r), strength_(strength), shift_(shift) {
    // An even density that explains the number of counts: what the ridge pulls towards, so that units do not
    // matter.
    const double exposure = p.A.sum();
    level_ = std::log(std::max(p.counts.sum(), kTiny) / std::max(exposure, 1e-300));
  }
  double level() const { return level_; }

  double value(const VectorXd& theta, VectorXd& x, VectorXd& mu) const {
    x = theta.array().exp();
    mu = (p_.A * x).cwiseMax(kTiny);
    double sum = (p_.counts.array() * mu.array().log()).sum() - mu.sum();
    if (p_.total.size() > 0) {
      const double miss = (p_.total.dot(x) - p_.known_total) / (p_.known_error * p_.known_total);
      sum -= miss * miss / 2;
    }
    VectorXd rough = r_.D * theta;
    if (shift_) rough -= *shift_;
    return sum - strength_ * rough.squaredNorm() / 2 - kRidge * (theta.array() - level_).square().sum() / 2;
  }

  void slopes(const VectorXd& theta, const VectorXd& x, const VectorXd& mu, VectorXd& gradient,
              MatrixXd& information) const {
    const MatrixXd J = p_.A * x.asDiagonal();
    gradient = J.transpose() * (p_.counts.array() / mu.array() - 1).matrix();
    information.noalias() = J.transpose() * mu.cwiseInverse().asDiagonal() * J;
    if (p_.total.size() > 0) {
      const double error = p_.known_error * p_.known_total;
      const VectorXd v = p_.total.cwiseProduct(x) / error;
      gradient -= (p_.total.dot(x) - p_.known_total) / error * v;
      information += v * v.transpose();
    }
    gradient -= strength_ * (r_.penalty * theta);
    if (shift_) gradient += strength_ * (r_.D.transpose() * *shift_);
    gradient.array() -= kRidge * (theta.array() - level_);
    information += strength_ * r_.penalty;
    information.diagonal().array() += kRidge;
  }

 private:
  const SmoothPoissonProblem& p_;
  const Roughness& r_;
  double strength_, level_;
  const VectorXd* shift_;
};

// Newton's method, damped after Levenberg, from theta; returns the value reached.
double climb(const Posterior& f, VectorXd& theta, MatrixXd& information) {
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
        theta = next, x.swap(next_x), mu.swap(next_mu), value = there;
        damping = damping > 1e-9 ? damping / 10 : 0;
      } else {
        damping = damping > 0 ? 10 * damping : 0.01 * information.diagonal().maxCoeff();
      }
    }
    if (gain < 1e-6) break;
  }
  f.slopes(theta, x, mu, gradient, information);
  return value;
}

}  // namespace

std::vector<SmoothPoissonFit> smooth_poisson_fits(const SmoothPoissonProblem& p, const Work& work) {
  // Decades of strength, the most first: from "nothing but the unpenalised form" to "any".
  struct Series {
    int order;
    double first;
    int count;
  };
  constexpr Series kSeries[] = {{1, 1e2, 8}, {2, 1e1, 10}, {3, 1e0, 13}};
  const Eigen::Index bins = p.A.cols();
  std::vector<std::vector<SmoothPoissonFit>> series(std::size(kSeries));
  work.parallel(std::size(kSeries), 1, [&](std::size_t s, std::size_t) {
    const Roughness r(kSeries[s].order, p.place);
    const double log_det = r.log_det();
    double strength = kSeries[s].first, best = -std::numeric_limits<double>::infinity();
    VectorXd theta;
    MatrixXd information(bins, bins);
    for (int k = 0; k < kSeries[s].count; ++k, strength /= 10) {
      work.check();
      const Posterior f(p, r, strength, nullptr);
      if (theta.size() == 0) theta = VectorXd::Constant(bins, f.level());
      const double value = climb(f, theta, information);
      SmoothPoissonFit fit;
      fit.order = r.order, fit.strength = strength, fit.theta = theta;
      const Eigen::LLT<MatrixXd> factor(information);
      fit.evidence = value + ((bins - r.order) * std::log(strength) + log_det) / 2 -
                     r.order * std::log(kVague) - log_determinant(factor) / 2;
      fit.freedom = static_cast<double>(bins) - strength * factor.solve(r.penalty).trace();
      best = std::max(best, fit.evidence);
      const bool hopeless = fit.evidence < best - kGiveUp;
      series[s].push_back(std::move(fit));
      if (hopeless) break;
    }
  });
  std::vector<SmoothPoissonFit> all;
  for (auto& s : series)
    for (auto& f : s) all.push_back(std::move(f));
  double best = all[0].evidence, sum = 0;
  for (const auto& f : all) best = std::max(best, f.evidence);
  for (auto& f : all) sum += f.weight = std::exp(f.evidence - best);
  std::erase_if(all, [&](const SmoothPoissonFit& f) { return f.weight < 1e-4 * sum; });
  sum = 0;
  for (const auto& f : all) sum += f.weight;
  for (auto& f : all) f.weight /= sum;
  return all;
}

VectorXd mean_density(const std::vector<SmoothPoissonFit>& fits) {
  VectorXd x = VectorXd::Zero(fits.front().theta.size());
  for (const auto& f : fits) x += f.weight * f.theta.array().exp().matrix();
  return x;
}

VectorXd draw_density(const SmoothPoissonProblem& p, const std::vector<SmoothPoissonFit>& fits,
                      Random& random) {
  double u = random.uniform();
  std::size_t k = 0;
  while (k + 1 < fits.size() && u >= fits[k].weight) u -= fits[k].weight, ++k;
  const SmoothPoissonFit& fit = fits[k];
  const Roughness r(fit.order, p.place);
  const double strength = kRougher * fit.strength;
  VectorXd shift(r.D.rows());
  for (auto& s : shift) s = random.normal() / std::sqrt(strength);
  VectorXd theta = fit.theta;
  MatrixXd information(theta.size(), theta.size());
  climb(Posterior(p, r, strength, &shift), theta, information);
  return theta.array().exp();
}

}  // namespace terrazzo
