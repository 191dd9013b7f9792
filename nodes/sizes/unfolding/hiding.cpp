#include "nodes/sizes/unfolding/hiding.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace terrazzo::unfolding {
namespace {

struct Knot {
  double ratio, seen;  // silhouettes per layer that look larger than ratio·size
};
// Of stones that are seen nearly whole, as Segment outlines them.
constexpr std::array<Knot, 8> kWhole{{{1.1, 0},
                                      {1.05, 0.045},
                                      {1, 0.17},
                                      {0.97, 0.32},
                                      {0.95, 0.43},
                                      {0.9, 0.66},
                                      {0.85, 0.79},
                                      {kSmallestWhole, 0.85}}};
constexpr std::array<Knot, 10> kParts{{{0.9, 0},
                                       {0.8, 0.1},
                                       {0.7, 0.18},
                                       {0.6, 0.26},
                                       {0.5, 0.36},
                                       {0.4, 0.5},
                                       {0.3, 0.68},
                                       {0.2, 0.95},
                                       {0.15, 1.17},
                                       {0.1, 1.31}}};

// Linear between knots of falling ratio, constant outside.
template <std::size_t n>
double seen_above(const std::array<Knot, n>& knots, double ratio) {
  if (ratio >= knots.front().ratio) return 0;
  for (std::size_t i = 1; i < n; ++i)
    if (ratio >= knots[i].ratio) {
      const double t = (knots[i - 1].ratio - ratio) / (knots[i - 1].ratio - knots[i].ratio);
      return std::lerp(knots[i - 1].seen, knots[i].seen, t);
    }
  return knots.back().seen;
}

// Of a spheroid with equatorial diameter 1 and this height below 1, over all directions.
double mean_caliper(double height) {
  const double e = std::sqrt(1 - height * height);
  return (height + std::asin(e) / e) / 2;
}
// The root of its mean silhouette's area relative to the equator's: a quarter of its surface (Cauchy).
double mean_silhouette(double height) {
  const double e = std::sqrt(1 - height * height);
  return std::sqrt((1 + height * height / e * std::atanh(e)) / 2);
}

constexpr int kSizes = 16;  // within a class
constexpr int kLeans = 8;   // silhouettes between the narrowest and the widest

}  // namespace

Hiding::Hiding(Bed bed, double height) : bed_(bed), depth_(height), narrowest_(1) {
  constexpr double kFlattest = 0.05, kRoundest = 0.999;  // so that formulas of spheroids have digits
  if (bed != Bed::Loose) return;
  const double h = std::clamp(height, kFlattest, kRoundest);
  depth_ = (h + mean_caliper(h)) / 2;
  narrowest_ = mean_silhouette(h);
}

double Hiding::above(double size, double seen) const {
  if (bed_ != Bed::Loose) return depth_ * size / kWhole.back().seen * seen_above(kWhole, seen / size);
  double sum = 0;
  for (int k = 0; k < kLeans; ++k) {
    const double ratio = seen / (size * std::lerp(narrowest_, 1, (k + 0.5) / kLeans));
    sum += (seen_above(kWhole, ratio) + seen_above(kParts, ratio)) / kLeans;
  }
  return depth_ * size * sum;
}

Eigen::MatrixXd Hiding::matrix(const std::vector<double>& profile_edges,
                               const std::vector<double>& size_edges) const {
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(profile_edges.size() - 1, size_edges.size() - 1);
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    for (int n = 0; n < kSizes; ++n) {
      const double size = std::lerp(size_edges[j], size_edges[j + 1], (n + 0.5) / kSizes);
      double larger = above(size, profile_edges[0]);
      for (Eigen::Index i = 0; i < m.rows(); ++i) {
        // The last class has no upper end: silhouettes may look larger than the largest stone.
        const double next = i + 1 < m.rows() ? above(size, profile_edges[i + 1]) : 0;
        m(i, j) += (larger - next) / kSizes;
        larger = next;
      }
    }
  return m;
}

}  // namespace terrazzo::unfolding
