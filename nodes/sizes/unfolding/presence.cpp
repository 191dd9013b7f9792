#include "nodes/sizes/unfolding/presence.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrazzo::unfolding {
namespace {

using Eigen::VectorXd;

constexpr double kTinyShare = 1e-12;  // lower bound of expected counts

class Likelihood {
 public:
  Likelihood(const Eigen::MatrixXd& A, const VectorXd& counts)
      : A_(A), counts_(counts), exposure_(A.colwise().sum().transpose().cwiseMax(kTinyShare)) {}

  double value(const VectorXd& x) const {
    const VectorXd mu = (A_ * x).cwiseMax(kTinyShare);
    return (counts_.array() * mu.array().log()).sum() - mu.sum();
  }

  // Maximizes until the gain vanishes or the value reaches `enough`, by extrapolated EM steps
  // (Varadhan and Roland 2008).
  double climb(VectorXd& x, double enough, const Work& work) const {
    double best = value(x);
    for (int round = 0; round < 120 && best < enough; ++round) {
      work.check();
      const VectorXd a = step(x), b = step(a), first = a - x, bend = b - a - first;
      VectorXd next = b;
      double there = value(b);
      if (const double length = bend.norm(); length > 0) {
        const double s = std::max(1.0, first.norm() / length);
        const VectorXd far = step((x + 2 * s * first + s * s * bend).cwiseMax(0.1 * b));
        if (const double other = value(far); other > there) {
          next = far;
          there = other;
        }
      }
      x = next;
      const double gain = there - best;
      best = there;
      if (gain < 1e-4) break;
    }
    return best;
  }

 private:
  VectorXd step(const VectorXd& x) const {
    return x.cwiseProduct(A_.transpose() * counts_.cwiseQuotient((A_ * x).cwiseMax(kTinyShare)))
        .cwiseQuotient(exposure_);
  }
  const Eigen::MatrixXd& A_;
  const VectorXd& counts_;
  VectorXd exposure_;
};

}  // namespace

std::vector<char> may_be_empty(const Eigen::MatrixXd& A, const VectorXd& counts, const std::vector<int>& cls,
                               const VectorXd& start, double drop, const Work& work) {
  const Likelihood f(A, counts);
  VectorXd x = start;
  const double most = f.climb(x, std::numeric_limits<double>::infinity(), work);
  std::vector<char> empty(1 + *std::max_element(cls.begin(), cls.end()));
  for (std::size_t c = 0; c < empty.size(); ++c) {
    VectorXd without = x + 1e-3 * start;  // EM never leaves zero, so the other bins must start above it
    for (std::size_t j = 0; j < cls.size(); ++j)
      if (cls[j] == static_cast<int>(c)) without[j] = 0;
    empty[c] = without.sum() > 0 && f.climb(without, most - drop, work) >= most - drop;
  }
  return empty;
}

}  // namespace terrazzo::unfolding
