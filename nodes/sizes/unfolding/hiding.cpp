#include "nodes/sizes/unfolding/hiding.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace terrazzo::unfolding {
namespace {

struct Knot {
  double ratio, share;  // share of silhouettes that look larger than ratio·size
};
// Completed outlines of stones that are seen nearly whole, and of parts. Smaller parts than the last are not
// recognized.
constexpr std::array<Knot, 4> kWhole{{{1.02, 0}, {0.97, 0.88}, {0.95, 0.94}, {0.9, 1}}};
constexpr std::array<Knot, 10> kParts{{{0.9, 0},
                                       {0.85, 0.035},
                                       {0.8, 0.08},
                                       {0.75, 0.12},
                                       {0.7, 0.16},
                                       {0.6, 0.28},
                                       {0.5, 0.40},
                                       {0.4, 0.56},
                                       {0.3, 0.76},
                                       {0.2, 1}}};

// Linear between knots of falling ratio, constant outside.
template <std::size_t n>
double share_above(const std::array<Knot, n>& knots, double ratio) {
  if (ratio >= knots.front().ratio) return 0;
  for (std::size_t i = 1; i < n; ++i)
    if (ratio >= knots[i].ratio) {
      const double t = (knots[i - 1].ratio - ratio) / (knots[i - 1].ratio - knots[i].ratio);
      return knots[i - 1].share + t * (knots[i].share - knots[i - 1].share);
    }
  return knots.back().share;
}

constexpr int kSteps = 16;  // sizes within a class

}  // namespace

Hiding::Hiding(std::vector<double> edges, const Eigen::VectorXd& volume)
    : edges_(std::move(edges)), above_(edges_.size(), 0) {
  for (Eigen::Index k = volume.size() - 1; k >= 0; --k) above_[k] = above_[k + 1] + volume[k];
  if (const double all = above_.front(); all > 0)
    for (double& v : above_) v /= all;
}

double Hiding::coarser(double size) const {
  if (edges_.empty()) return 0.5;
  if (size <= edges_.front()) return 1;
  if (size >= edges_.back()) return 0;
  const std::size_t k = std::upper_bound(edges_.begin(), edges_.end(), size) - edges_.begin();
  const double t = (size - edges_[k - 1]) / (edges_[k] - edges_[k - 1]);
  return above_[k - 1] + t * (above_[k] - above_[k - 1]);
}

double Hiding::seen_above(double size, double seen) const {
  const double g = coarser(size), ratio = seen / size;
  return size * ((0.92 + 0.35 * g) * share_above(kWhole, ratio) +
                 1.15 * (1 - std::exp(-4 * g)) * share_above(kParts, ratio));
}

Eigen::MatrixXd Hiding::matrix(const std::vector<double>& profile_edges,
                               const std::vector<double>& size_edges) const {
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(profile_edges.size() - 1, size_edges.size() - 1);
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    for (int step = 0; step < kSteps; ++step) {
      const double size = size_edges[j] + (size_edges[j + 1] - size_edges[j]) * (step + 0.5) / kSteps;
      double above = seen_above(size, profile_edges[0]);
      for (Eigen::Index i = 0; i < m.rows(); ++i) {
        // The last class has no upper end: silhouettes may look larger than the largest stone.
        const double next = i + 1 < m.rows() ? seen_above(size, profile_edges[i + 1]) : 0;
        m(i, j) += (above - next) / kSteps;
        above = next;
      }
    }
  return m;
}

}  // namespace terrazzo::unfolding
