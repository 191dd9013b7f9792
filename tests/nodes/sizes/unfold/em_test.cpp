// What the default method guarantees: a smaller error than least squares, an error that falls with more
// profiles, and intervals that contain the truth as often as they claim. Distributions as in figure 7 of
// Jagnow et al. 2004.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "nodes/common/stereology/size_kernel.h"
#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "nodes/sizes/unfolding/bootstrap.h"
#include "nodes/sizes/unfolding/presence.h"
#include "nodes/sizes/unfolding/smooth_poisson.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace kmatrix;
using namespace unfolding;

KMatrix kmatrix_of(const std::string& kind) {
  const auto shapes = test::run_node("Shape", {}, {{"kind", kind}, {"size", "1"}}).outputs.at("shapes");
  return make_kmatrix(shapes.as<Shapes>(),
                      {.method = kind == "sphere" ? kmatrix::Method::Analytic : kmatrix::Method::Slice,
                       .classes = 10,
                       .orientations = kind == "sphere" ? std::size_t{0} : 2000});
}

// Sizes in [0, 1] with a density proportional to `density`; Σ N_V is 1 per mm³.
class Population {
 public:
  Population(const KMatrix& k, const std::function<double(double)>& density) : k_(k), share_(kCells) {
    double sum = 0;
    for (int i = 0; i < kCells; ++i) sum += share_[i] = density((i + 0.5) / kCells);
    for (double& s : share_) s /= sum;
    for (int i = 0; i < kCells; ++i)
      seen_.push_back((seen_.empty() ? 0 : seen_.back()) + share_[i] * (i + 0.5) / kCells);
    const auto& cdf = k.shapes[0].cdf;
    std::size_t b = 0;
    for (int q = 0; q <= kQuantiles; ++q) {
      while (b + 1 < cdf.size() && cdf[b] < static_cast<double>(q) / kQuantiles) ++b;
      const double before = b > 0 ? cdf[b - 1] : 0, rise = cdf[b] - before;
      const double within = rise > 0 ? (static_cast<double>(q) / kQuantiles - before) / rise : 1;
      relative_.push_back((static_cast<double>(b) + std::clamp(within, 0.0, 1.0)) /
                          static_cast<double>(cdf.size()));
    }
  }
  // Profiles of a window that shows `expected` of them on average.
  Profiles sample(int expected, std::uint64_t seed) const {
    const auto& e = k_.shapes[0];
    const double size = std::sqrt(4 * e.max_section_area / std::numbers::pi);
    Profiles p;
    p.observed_area = expected / (seen_.back() * e.mean_caliper / size * e.profiles_per_caliper);
    Random random(seed);
    const auto n = std::lround(expected + std::sqrt(expected) * random.normal());
    double covered = 0;
    for (long i = 0; i < n; ++i) {
      const double u = random.uniform() * seen_.back();
      const auto cell = std::lower_bound(seen_.begin(), seen_.end(), u) - seen_.begin();
      const double at = random.uniform() * kQuantiles;
      const auto q = static_cast<std::size_t>(at);
      const double s = relative_[q] + (at - static_cast<double>(q)) * (relative_[q + 1] - relative_[q]);
      const double profile = s * (static_cast<double>(cell) + random.uniform()) / kCells;
      if (!(profile > 0)) continue;
      p.profiles.emplace_back().area = std::numbers::pi / 4 * profile * profile;
      covered += p.profiles.back().area;
    }
    p.area_fraction = covered / p.observed_area;
    // The densities of this test would overfill space, so thin them: only ratios matter here.
    const double thin = 0.2 / p.area_fraction;
    p.observed_area /= thin;
    p.area_fraction *= thin;
    return p;
  }
  double between(double a, double b) const {
    double sum = 0;
    for (int i = 0; i < kCells; ++i)
      sum += share_[i] *
             std::clamp(
                 (std::min(b, (i + 1.0) / kCells) - std::max(a, static_cast<double>(i) / kCells)) * kCells,
                 0.0, 1.0);
    return sum;
  }

 private:
  static constexpr int kCells = 1000, kQuantiles = 20000;
  const KMatrix& k_;
  std::vector<double> share_, seen_, relative_;
};

double bell(double x, double mean, double sd) { return std::exp(-0.5 * std::pow((x - mean) / sd, 2)) / sd; }

const std::vector<std::pair<std::string, std::function<double(double)>>>& figure7() {
  static const std::vector<std::pair<std::string, std::function<double(double)>>> laws = {
      {"single", [](double x) { return bell(x, 0.5, 0.12); }},
      {"bimodal", [](double x) { return bell(x, 0.3, 0.07) + bell(x, 0.7, 0.08); }},
      {"lognormal", [](double x) { return bell(std::log(x), std::log(0.3), 0.4) / x; }},
      {"constant", [](double) { return 1.0; }}};
  return laws;
}

// L1 error of N_V over the classes, relative to Σ N_V.
double l1_error(const UnfoldResult& r, const Population& truth, double true_sum) {
  double error = 0;
  for (std::size_t j = 0; j < r.distribution.classes(); ++j)
    error += std::abs(r.distribution.shapes[0].N_V[j] / true_sum -
                      truth.between(r.distribution.class_edges[j], r.distribution.class_edges[j + 1]));
  return error;
}

// True Σ N_V of a sample: 1 per mm³ times the thinning factor of `sample`.
double sum_of(const Profiles& p, const KMatrix& k, const Population&, double mean_size, int expected) {
  const auto& e = k.shapes[0];
  const double size = std::sqrt(4 * e.max_section_area / std::numbers::pi);
  return expected / (mean_size * e.mean_caliper / size * e.profiles_per_caliper) / p.observed_area;
}

double mean_size(const Population& t) {
  double sum = 0;
  for (int i = 0; i < 1000; ++i) sum += t.between(i / 1000.0, (i + 1) / 1000.0) * (i + 0.5) / 1000;
  return sum;
}

TEST(UnfoldEm, ErrsLessThanLeastSquaresOnFigure7AndLessWithMoreProfiles) {
  const KMatrix k = kmatrix_of("sphere");
  const double at_most[] = {0.14, 0.21, 0.15, 0.14};  // means over 200 repetitions: 0.08, 0.14, 0.08, 0.08
  for (std::size_t law = 0; law < figure7().size(); ++law) {
    const auto& [name, density] = figure7()[law];
    const Population truth(k, density);
    const double mean = mean_size(truth);
    double em = 0, nnls = 0;
    constexpr int kRepetitions = 2;
    for (int r = 0; r < kRepetitions; ++r) {
      const Profiles p = truth.sample(1200, 100 + r);
      const double sum = sum_of(p, k, truth, mean, 1200);
      em += l1_error(unfold(p, k, {}, {}), truth, sum) / kRepetitions;
      nnls += l1_error(unfold(p, k, {.method = unfolding::Method::Nnls}, {}), truth, sum) / kRepetitions;
    }
    EXPECT_LT(em, at_most[law]) << name;
    EXPECT_LT(em, nnls) << name;
    const Profiles many = truth.sample(20000, 7);
    EXPECT_LT(l1_error(unfold(many, k, {.d_max = 1}, {}), truth, sum_of(many, k, truth, mean, 20000)), 0.07)
        << name;
  }
}

// On average, n draws divide the unit interval into n + 1 equal parts, so the interval of 5 to 95 % holds the
// truth nine times in ten with few repetitions of the bootstrap as with many.
TEST(Bootstrap, QuantilesHoldAFurtherDraw) {
  for (const int n : {19, 60, 1000}) {
    std::vector<double> values;
    for (int i = 1; i <= n; ++i) values.push_back(i / (n + 1.0));
    for (const double q : {0.05, 0.5, 0.95}) EXPECT_NEAR(quantile(values, q), q, 1e-12) << n;
  }
  std::vector<double> one{3};
  EXPECT_EQ(quantile(one, 0.95), 3);
}

// Pooled over 5 repetitions of 10 classes. The classes are correlated, so the bounds are wide. The long-run
// coverage is between 85 and 95 %.
TEST(UnfoldEm, IntervalsHoldTheTruthAboutNineTimesInTen) {
  for (const auto* body : {"sphere", "octahedron"}) {
    const KMatrix k = kmatrix_of(body);
    int held = 0, of = 0;
    for (const std::size_t law : {1, 2}) {
      const Population truth(k, figure7()[law].second);
      const double mean = mean_size(truth);
      for (int r = 0; r < 5; ++r) {
        const Profiles p = truth.sample(1200, 300 + r);
        const double sum = sum_of(p, k, truth, mean, 1200);
        const UnfoldResult u = unfold(p, k, {.smallest_visible = 0, .d_max = 1, .bootstrap = 40}, {});
        for (std::size_t j = 0; j < 10; ++j, ++of) {
          const double t =
              truth.between(u.distribution.class_edges[j], u.distribution.class_edges[j + 1]) * sum;
          const auto& e = u.distribution.shapes[0];
          held += t >= e.low[j] * (1 - 1e-9) && t <= e.high[j] * (1 + 1e-9);
        }
      }
    }
    EXPECT_GT(static_cast<double>(held) / of, 0.78) << body;
    EXPECT_LT(static_cast<double>(held) / of, 0.98) << body;
  }
}

// Sizes cut off by sieves, as for aggregates: mean over 4 repetitions. The error of `nnls` is about 0.2.
TEST(UnfoldEm, DensitiesMayJump) {
  const KMatrix k = kmatrix_of("sphere");
  const std::pair<double, double> cuts[] = {{0.5, 1.0}, {0.35, 0.75}};
  for (const auto& [lo, hi] : cuts) {
    const Population truth(k, [&](double x) { return static_cast<double>(x > lo && x < hi); });
    const double mean = mean_size(truth);
    double em = 0, nnls = 0, jumps = 0;
    int held = 0, of = 0;
    for (int r = 0; r < 4; ++r) {
      const Profiles p = truth.sample(2000, 500 + r);
      const double sum = sum_of(p, k, truth, mean, 2000);
      const UnfoldResult u = unfold(p, k, {.smallest_visible = 0, .d_max = hi, .bootstrap = 40}, {});
      em += l1_error(u, truth, sum) / 4;
      jumps += u.fits[0].jumps / 4;
      nnls +=
          l1_error(unfold(p, k, {.method = unfolding::Method::Nnls, .smallest_visible = 0, .d_max = hi}, {}),
                   truth, sum) /
          4;
      for (std::size_t j = 0; j < 10; ++j, ++of) {
        const double t =
            truth.between(u.distribution.class_edges[j], u.distribution.class_edges[j + 1]) * sum;
        const auto& e = u.distribution.shapes[0];
        held += t >= e.low[j] * (1 - 1e-9) && t <= e.high[j] * (1 + 1e-9);
      }
    }
    EXPECT_LT(em, 0.14);
    EXPECT_LT(em, nnls);
    EXPECT_GT(jumps, 0.4);
    EXPECT_GT(static_cast<double>(held) / of, 0.8);  // 0.94 in the long run
  }
}

TEST(SmoothPoisson, FindsAJumpAndNothingElse) {
  SmoothPoissonProblem p;
  p.A = Eigen::MatrixXd::Identity(30, 30);
  p.counts = Eigen::VectorXd::Constant(30, 20);
  p.counts.tail(18).setConstant(80);
  p.place = Eigen::VectorXd::LinSpaced(30, 0, 1);
  const auto fits = smooth_poisson_fits(p, {});
  double there = 0, jumps = 0;
  for (const auto& f : fits) {
    jumps += f.weight * static_cast<double>(f.breaks.size());
    for (const int b : f.breaks) there += b == 11 ? f.weight : 0;
  }
  EXPECT_GT(there, 0.95);
  EXPECT_LT(jumps, 1.3);
  const Eigen::VectorXd x = mean_density(fits);
  for (int j = 0; j < 30; ++j) EXPECT_NEAR(x[j] / p.counts[j], 1, 0.05) << j;
}

TEST(Presence, OnlyWhatCountsShowIsThere) {
  // Three classes of two bins, each seen independently; the second has no counts, the third almost none.
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(6, 6);
  Eigen::VectorXd counts(6);
  counts << 10, 12, 0, 0, 1, 0;
  const std::vector<int> cls{0, 0, 1, 1, 2, 2};
  const Eigen::VectorXd start = Eigen::VectorXd::Constant(6, 4);
  EXPECT_EQ(may_be_empty(A, counts, cls, start, 1.353, {}), (std::vector<char>{0, 1, 0}));
  // A profile that two classes can show is evidence for neither.
  Eigen::MatrixXd both(2, 2);
  both << 1, 1, 0, 1;
  Eigen::VectorXd seen(2);
  seen << 20, 0;
  EXPECT_EQ(may_be_empty(both, seen, {0, 1}, Eigen::VectorXd::Constant(2, 5), 1.353, {}),
            (std::vector<char>{0, 1}));
}

TEST(SmoothPoisson, FindsAnEvenDensityFromEvenCounts) {
  SmoothPoissonProblem p;
  p.A = Eigen::MatrixXd::Identity(20, 20) * 5;
  p.counts = Eigen::VectorXd::Constant(20, 30);
  p.place = Eigen::VectorXd::LinSpaced(20, 0.025, 0.975);
  const auto fits = smooth_poisson_fits(p, {});
  const Eigen::VectorXd x = mean_density(fits);
  double weight = 0;
  for (const auto& f : fits) weight += f.weight;
  EXPECT_NEAR(weight, 1, 1e-12);
  for (const double v : x) EXPECT_NEAR(v, 6, 1e-3);
  // The smoothest of the orders wins, because there is no evidence for more.
  for (const auto& f : fits)
    if (f.weight > 0.5) {
      EXPECT_EQ(f.order, 1);
    }
}

TEST(SmoothPoisson, UnitsDoNotMatter) {
  SmoothPoissonProblem p;
  p.A = Eigen::MatrixXd::Identity(12, 12);
  p.counts.resize(12);
  p.counts << 0, 1, 4, 9, 25, 40, 33, 20, 8, 3, 0, 0;
  p.place = Eigen::VectorXd::LinSpaced(12, 0, 1);
  const Eigen::VectorXd x = mean_density(smooth_poisson_fits(p, {}));
  p.A *= 1e9;
  const Eigen::VectorXd y = mean_density(smooth_poisson_fits(p, {}));
  EXPECT_LT((y * 1e9 - x).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_NEAR(x.sum(), p.counts.sum(), 1);
}

TEST(SmoothPoisson, AKnownTotalIsMet) {
  SmoothPoissonProblem p;
  p.A = Eigen::MatrixXd::Identity(10, 10);
  p.counts = Eigen::VectorXd::LinSpaced(10, 5, 14);
  p.place = Eigen::VectorXd::LinSpaced(10, 0, 1);
  p.total = Eigen::VectorXd::Ones(10);
  p.known_total = 120;
  p.known_error = 0.001;
  EXPECT_NEAR(mean_density(smooth_poisson_fits(p, {})).sum(), 120, 0.5);
}

}  // namespace
}  // namespace terrazzo
