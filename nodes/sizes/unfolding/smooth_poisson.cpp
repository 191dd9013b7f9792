#include "nodes/sizes/unfolding/smooth_poisson.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <Eigen/Cholesky>

#include "nodes/sizes/unfolding/posterior.h"

namespace terrazzo::unfolding {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Breaks = std::vector<int>;
using Fits = std::vector<SmoothPoissonFit>;

constexpr int kOrders = 3;
// Decades of strength, strongest first: from "only the unpenalized form" to "any form".
struct Series {
  double first;
  int count;
};
constexpr Series kSeries[kOrders] = {{1e2, 8}, {1e1, 10}, {1e0, 13}};
constexpr double kGiveUp = 25;       // stop a series of strengths this far below the best log evidence
constexpr double kAnother = 0.5;     // prior probability of one more break
constexpr int kMostBreaks = 4;       // largest number of breaks searched for
constexpr std::size_t kParents = 3;  // sets of breaks that are extended by another break
constexpr double kNoParent = 3;      // sets this far below the best log evidence are not extended
constexpr double kHopeless = 12;     // stop fitting a break this far below the best log evidence
constexpr Eigen::Index kMostBins = 120;
// Factor on the strength in draws: intervals exclude the bias of smoothing only if the draws smooth less.
constexpr double kRougher = 0.01;
constexpr double kNever = -std::numeric_limits<double>::infinity();

double log_determinant(const Eigen::LLT<MatrixXd>& l) {
  double sum = 0;
  for (Eigen::Index i = 0; i < l.matrixLLT().rows(); ++i) sum += std::log(l.matrixLLT()(i, i));
  return 2 * sum;
}

double best_of(const Fits& fits) {
  double best = kNever;
  for (const auto& f : fits) best = std::max(best, f.evidence);
  return best;
}

class Search {
 public:
  explicit Search(const SmoothPoissonProblem& p) : p_(p), level_(even_level(p)), bins_(p.A.cols()) {
    for (int order = 1; order <= kOrders; ++order) differences_.push_back(roughness(order, p.place));
  }
  int bins() const { return bins_; }

  // Fits all strengths of an order without breaks.
  Fits without_breaks(int order, const Work& work) const {
    Fits fits;
    double strength = kSeries[order - 1].first, best = kNever;
    VectorXd theta = VectorXd::Constant(bins_, level_);
    for (int k = 0; k < kSeries[order - 1].count; ++k, strength /= 10) {
      work.check();
      fits.push_back(fit(order, strength, {}, theta, 1e-6));
      theta = fits.back().theta;
      best = std::max(best, fits.back().evidence);
      if (fits.back().evidence != kNever && fits.back().evidence < best - kGiveUp) break;
    }
    return fits;
  }

  // Starts from the best fit of each order with one break fewer. Smoothing no longer has to accommodate the
  // jump, so the strength rises as long as that increases the evidence.
  Fits with_break(const Breaks& breaks, const Fits& parents, double best, const Work& work) const {
    Fits fits;
    for (int order = 1; order <= kOrders; ++order) {
      const SmoothPoissonFit* from = nullptr;
      for (const auto& f : parents)
        if (f.order == order && (!from || f.evidence > from->evidence)) from = &f;
      if (!from) continue;
      VectorXd theta = from->theta;
      double last = kNever;
      for (double s = from->strength; s < 2 * kSeries[order - 1].first; s *= 10) {
        work.check();
        fits.push_back(fit(order, s, breaks, theta, 1e-4));
        const double e = fits.back().evidence;
        if (e < last || e < best - kHopeless) break;
        theta = fits.back().theta;
        last = e;
      }
    }
    return fits;
  }

 private:
  double log_prior(std::size_t breaks) const {
    double sum = std::log(1 - kAnother);
    for (std::size_t m = 0; m < breaks; ++m)
      sum += std::log(kAnother * static_cast<double>(m + 1) / (bins_ - 1 - m));
    return sum;
  }

  SmoothPoissonFit fit(int order, double strength, const Breaks& breaks, const VectorXd& start,
                       double enough) const {
    const SmoothPrior prior = smooth_prior(order, differences_[order - 1], strength, breaks, level_);
    SmoothPoissonFit f;
    f.order = order;
    f.strength = strength;
    f.breaks = breaks;
    f.theta = start;
    MatrixXd information(bins_, bins_);
    const double value = climb(Posterior(p_, prior), f.theta, information, enough);
    const Eigen::LLT<MatrixXd> factor(information);
    f.evidence = value + (prior.log_det - log_determinant(factor)) / 2 + log_prior(breaks.size());
    // With few counts, rounding can make the information singular. That is no evidence for or against this
    // prior, but its densities are unusable.
    if (!std::isfinite(f.evidence)) f.evidence = kNever;
    f.freedom = bins_ - factor.solve(prior.precision).trace();
    return f;
  }

  const SmoothPoissonProblem& p_;
  double level_;
  Eigen::Index bins_;
  std::vector<MatrixXd> differences_;
};

// Adds the sets with one break more than each of `parents`; returns the most probable of them.
std::vector<Breaks> add_breaks(const Search& search, const std::vector<Breaks>& parents,
                               std::map<Breaks, Fits>& sets, double& best, const Work& work) {
  std::map<Breaks, const Fits*> from;
  for (const Breaks& parent : parents)
    for (int b = 0; b + 1 < search.bins(); ++b) {
      if (std::find(parent.begin(), parent.end(), b) != parent.end()) continue;
      Breaks breaks = parent;
      breaks.insert(std::upper_bound(breaks.begin(), breaks.end(), b), b);
      if (!sets.count(breaks)) from.emplace(std::move(breaks), &sets.at(parent));
    }
  const std::vector<std::pair<Breaks, const Fits*>> list(from.begin(), from.end());
  std::vector<Fits> found(list.size());
  work.parallel(list.size(), 1, [&](std::size_t i, std::size_t) {
    found[i] = search.with_break(list[i].first, *list[i].second, best, work);
  });

  std::vector<std::pair<double, Breaks>> ranked;
  for (std::size_t i = 0; i < list.size(); ++i) ranked.emplace_back(best_of(found[i]), list[i].first);
  for (std::size_t i = 0; i < list.size(); ++i) sets.emplace(list[i].first, std::move(found[i]));
  std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  std::vector<Breaks> next;
  if (ranked.empty() || ranked.front().first < best - 1) return next;  // another break does not help
  best = std::max(best, ranked.front().first);
  for (const auto& [evidence, breaks] : ranked)
    if (next.size() < kParents && evidence > best - kNoParent) next.push_back(breaks);
  return next;
}

}  // namespace

std::vector<SmoothPoissonFit> smooth_poisson_fits(const SmoothPoissonProblem& p, const Work& work) {
  const Search search(p);
  std::vector<Fits> orders(kOrders);
  work.part(0, 0.2).parallel(kOrders, 1, [&](std::size_t s, std::size_t) {
    orders[s] = search.without_breaks(static_cast<int>(s) + 1, work);
  });
  std::map<Breaks, Fits> sets;
  for (auto& o : orders) sets[{}].insert(sets[{}].end(), o.begin(), o.end());
  double best = best_of(sets[{}]);
  std::vector<Breaks> parents{{}};
  if (p.A.cols() > kMostBins) parents.clear();
  for (int k = 0; k < kMostBreaks && !parents.empty(); ++k)
    parents = add_breaks(search, parents, sets, best,
                         work.part(0.2 + 0.8 * k / kMostBreaks, 0.2 + 0.8 * (k + 1) / kMostBreaks));

  Fits all;
  double sum = 0;
  for (auto& [breaks, fits] : sets)
    for (auto& f : fits) {
      f.weight = std::exp(f.evidence - best);
      sum += f.weight;
      all.push_back(std::move(f));
    }
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
  while (k + 1 < fits.size() && u >= fits[k].weight) {
    u -= fits[k].weight;
    ++k;
  }
  const SmoothPoissonFit& fit = fits[k];
  const SmoothPrior prior = smooth_prior(fit.order, roughness(fit.order, p.place), kRougher * fit.strength,
                                         fit.breaks, even_level(p));
  VectorXd shift(prior.D.rows()), off(prior.ridge.size());
  for (auto& s : shift) s = random.normal() / std::sqrt(prior.strength);
  for (Eigen::Index j = 0; j < off.size(); ++j) off[j] = random.normal() / std::sqrt(prior.ridge[j]);
  VectorXd theta = fit.theta;
  MatrixXd information(theta.size(), theta.size());
  climb(Posterior(p, prior, &shift, &off), theta, information, 1e-6);
  return theta.array().exp();
}

}  // namespace terrazzo::unfolding
