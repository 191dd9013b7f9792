#include "nodes/shapes/shape_estimate/form_by_size.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/rank.h"
#include "nodes/shapes/shape_estimate/lobed.h"

namespace terrazzo::shape_estimate {
namespace {

constexpr double kFormStep = 0.15;  // width of a class, of the logarithm of the size
constexpr double kBeyond = 0.45;    // of the logarithm: particles may be larger than the largest profile
constexpr std::size_t kFormPlanes = 200;
constexpr int kWithin = 5;  // sizes within a class
constexpr int kFormRounds = 300, kNewtonSteps = 30;
constexpr double kMerged = 0.1;           // share of profiles that are lobed because particles touch
constexpr double kEvidence = 3;           // for lobed particles: odds of twenty
constexpr double kTrendEvidence = 1.353;  // ½·1.645²: a one-sided test at 5 % rejects
constexpr double kLevelSpread = 4, kTrendSpread = 10;  // of a weak prior
constexpr double kNever = 1e-9;                        // probability of what the sections never show

// Profiles per particle density, by class of the profile (rows; compact ones, then lobed ones) and of the
// particle (columns).
using Kernel = Eigen::MatrixXd;

struct Classes {
  double first = 0;  // logarithm of the smallest profile's size
  int profiles = 0, sizes = 0;
  double size(double j) const { return std::exp(first + j * kFormStep); }
  int row(double size, bool lobed) const {
    const int k =
        std::clamp(static_cast<int>(std::floor((std::log(size) - first) / kFormStep)), 0, profiles - 1);
    return lobed ? profiles + k : k;
  }
};

void add_body(Kernel& kernel, const Classes& classes, const Shape& body, double share,
              const ProfileMeasuring& how, const Work& work) {
  const std::vector<CutProfile> sections = cut_sections(body.mesh, kFormPlanes);
  for (int j = 0; j < classes.sizes; ++j) {
    work.check();
    const double middle = classes.size(j + 0.5) / body.size();  // mm per unit of the body
    for (const CutProfile& s : sections) {
      const bool lobed = convexity_of(s, middle, how) < kLobed;
      for (int i = 0; i < kWithin; ++i) {
        const double scale = classes.size(j + (i + 0.5) / kWithin) / body.size();
        const double size = scale * s.root_area * 2 / std::sqrt(std::numbers::pi);
        if (std::log(size) < classes.first) continue;
        kernel(classes.row(size, lobed), j) += share * scale * s.weight / (kFormPlanes * kWithin);
      }
    }
  }
}

Kernel kernel_of(const std::vector<Shape>& bodies, const Classes& classes, const ProfileMeasuring& how,
                 const Work& work) {
  double total = 0;
  for (const Shape& s : bodies) total += s.probability;
  std::vector<Kernel> each(bodies.size(), Kernel::Zero(2 * classes.profiles, classes.sizes));
  work.parallel(bodies.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      add_body(each[i], classes, bodies[i], bodies[i].probability / total, how, work);
  });
  Kernel out = Kernel::Zero(2 * classes.profiles, classes.sizes);
  for (const Kernel& k : each) out += k;
  const Kernel merged = kMerged * out.topRows(classes.profiles);
  out.topRows(classes.profiles) -= merged;
  out.bottomRows(classes.profiles) += merged;
  return out;
}

// The share of lobed particles by size, and the log likelihood of the profiles.
struct Solution {
  double level = 0, trend = 0, likelihood = 0;
};

class Problem {
 public:
  Problem(const Eigen::VectorXd& counts, const Kernel& compact, const Kernel& lobed, Eigen::VectorXd place)
      : counts_(counts), kernels_{&compact, &lobed}, place_(std::move(place)) {
    for (int g = 0; g < 2; ++g) seen_[g] = kernels_[g]->colwise().sum();
  }

  // `any`: there may be lobed particles; `trend`: their share may depend on the size.
  Solution solve(bool any, bool trend) const {
    Solution s;
    Eigen::VectorXd number = Eigen::VectorXd::Ones(place_.size());
    for (int round = 0; round < kFormRounds; ++round) {
      const Eigen::VectorXd share = shares(s, any);
      const std::array<Eigen::VectorXd, 2> part{number.cwiseProduct((1 - share.array()).matrix()),
                                                number.cwiseProduct(share)};
      const Eigen::VectorXd expected =
          (*kernels_[0] * part[0] + *kernels_[1] * part[1]).cwiseMax(kNever * number.sum());
      const Eigen::VectorXd ratio = counts_.cwiseQuotient(expected);
      std::array<Eigen::VectorXd, 2> from;  // expected number of profiles that each class and group shows
      Eigen::VectorXd exposure = Eigen::VectorXd::Zero(place_.size());
      for (int g = 0; g < 2; ++g) {
        from[g] = part[g].cwiseProduct(kernels_[g]->transpose() * ratio);
        exposure += (g == 0 ? (1 - share.array()).matrix() : share).cwiseProduct(seen_[g]);
      }
      s.likelihood = counts_.dot(expected.array().log().matrix()) - number.dot(exposure);
      number = (from[0] + from[1]).cwiseQuotient(exposure.cwiseMax(1e-300));
      if (any) update(s, from, trend);
    }
    return s;
  }

 private:
  Eigen::VectorXd shares(const Solution& s, bool any) const {
    if (!any) return Eigen::VectorXd::Zero(place_.size());
    return (1 + (-(s.level + s.trend * place_.array())).exp()).inverse().matrix();
  }

  // Newton's method for the logistic regression of profiles' groups on the size. Groups show different
  // numbers of profiles.
  void update(Solution& s, const std::array<Eigen::VectorXd, 2>& from, bool trend) const {
    for (int step = 0; step < kNewtonSteps; ++step) {
      Eigen::Vector2d slope(-s.level / (kLevelSpread * kLevelSpread),
                            -s.trend / (kTrendSpread * kTrendSpread));
      Eigen::Matrix2d curvature =
          Eigen::Vector2d(1 / (kLevelSpread * kLevelSpread), 1 / (kTrendSpread * kTrendSpread)).asDiagonal();
      for (Eigen::Index j = 0; j < place_.size(); ++j) {
        if (!(seen_[0][j] > 0) || !(seen_[1][j] > 0)) continue;
        const double odds = std::exp(s.level + s.trend * place_[j]) * seen_[1][j] / seen_[0][j];
        const double share = odds / (1 + odds), all = from[0][j] + from[1][j];
        const Eigen::Vector2d x(1, trend ? place_[j] : 0);
        slope += (from[1][j] - all * share) * x;
        curvature += all * share * (1 - share) * x * x.transpose();
      }
      const Eigen::Vector2d move = curvature.ldlt().solve(slope).cwiseMax(-1).cwiseMin(1);
      s.level += move[0];
      if (trend) s.trend += move[1];
      if (move.norm() < 1e-9) return;
    }
  }

  const Eigen::VectorXd& counts_;
  std::array<const Kernel*, 2> kernels_;
  std::array<Eigen::VectorXd, 2> seen_;
  Eigen::VectorXd place_;
};

}  // namespace

LobedShare lobed_share(const std::vector<SeenProfile>& profiles, const std::vector<Shape>& compact,
                       const std::vector<Shape>& lobed, const ProfileMeasuring& how, const Work& work) {
  std::vector<double> sizes;
  double weights = 0, squares = 0;
  for (const SeenProfile& p : profiles) {
    sizes.push_back(p.size);
    weights += p.weight;
    squares += p.weight * p.weight;
  }
  LobedShare out;
  if (sizes.empty() || !(weights > 0)) return out;
  Classes classes;
  classes.first = std::log(*std::min_element(sizes.begin(), sizes.end()) * (1 - 1e-9));
  const double range = std::log(*std::max_element(sizes.begin(), sizes.end())) - classes.first;
  classes.profiles = static_cast<int>(range / kFormStep) + 2;  // none is in the last
  classes.sizes = static_cast<int>((range + kBeyond) / kFormStep) + 1;
  out.middle = median(std::move(sizes));
  // Weighted profiles carry less information, by the factor Σw²/Σw.
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(2 * classes.profiles);
  for (const SeenProfile& p : profiles) counts[classes.row(p.size, p.lobed)] += p.weight * weights / squares;
  const Kernel first = kernel_of(compact, classes, how, work.part(0, 0.5)),
               second = kernel_of(lobed, classes, how, work.part(0.5, 1));
  Eigen::VectorXd place(classes.sizes);
  for (int j = 0; j < classes.sizes; ++j) place[j] = std::log(classes.size(j + 0.5) / out.middle);
  const Problem problem(counts, first, second, place);
  const double none = problem.solve(false, false).likelihood, even = problem.solve(true, false).likelihood;
  const Solution best = problem.solve(true, true);
  if (!(best.trend > 0 && best.likelihood > std::max(none + kEvidence, even) + kTrendEvidence)) return out;
  out.any = true;
  out.level = best.level;
  out.trend = best.trend;
  return out;
}

}  // namespace terrazzo::shape_estimate
