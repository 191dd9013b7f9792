#include "nodes/shapes/shape_estimate/feature_match.h"

#include <algorithm>
#include <cmath>

#include "runtime/random.h"

namespace terrazzo::shape_estimate {

namespace {

// Just visible differences in the order of ProfileFeatures, used as the smallest unit; the last is of sizes.
constexpr std::array<double, kFeatures + 1> kLeastSpread{0.0012, 0.12, 0.03, 0.006, 4,    0.7,  0.02, 0.015,
                                                         0.1,    0.05, 0.15, 0.02,  0.02, 0.01, 0.1};
// The features that people notice first have the largest weights.
constexpr std::array<double, kFeatures + 1> kImportance{1.5, 1.5, 1,   1, 1, 0.5, 0.7, 0.5,
                                                        0.5, 0.5, 0.5, 1, 1, 1,   0};

// Weight of the means' Mahalanobis distance. Weight of area-weighted means for particles of one size: large
// sections are the random sections that are closest to central ones.
constexpr double kToldByMeans = 0.5, kByArea = 20;

}  // namespace

FeatureTarget::FeatureTarget(const FeatureSample& observed, bool sizes, std::uint64_t seed) {
  const double total = total_weight(observed);
  mean_root_area_ = 0;
  for (std::size_t i = 0; i < observed.weight.size(); ++i)
    mean_root_area_ += observed.weight[i] * observed.root_area[i] / total;
  scale_.fill(1);
  const auto raw = standard(observed);
  importance_ = kImportance;
  if (sizes) importance_[kFeatures] = 1;
  for (std::size_t k = 0; k < kAxes; ++k) {
    double mean = 0, square = 0;
    for (std::size_t i = 0; i < raw.size(); ++i) mean += observed.weight[i] * raw[i][k] / total;
    for (std::size_t i = 0; i < raw.size(); ++i)
      square += observed.weight[i] * (raw[i][k] - mean) * (raw[i][k] - mean) / total;
    center_[k] = mean;
    scale_[k] = 1 / std::max(std::sqrt(square), kLeastSpread[k]);
  }
  for (std::size_t d = 0; d < kDirections; ++d) {
    Random r(seed, 205, d);
    Point p{};
    double norm = 0;
    for (std::size_t k = 0; k < kAxes; ++k) {
      p[k] = r.normal() * std::sqrt(importance_[k]);
      norm += p[k] * p[k];
    }
    for (double& v : p) v /= std::sqrt(norm);
    directions_.push_back(p);
  }
  const auto points = standard(observed);
  using Matrix = Eigen::Matrix<double, kFeatures, kFeatures>;
  Matrix covariance = Matrix::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Map<const Eigen::Matrix<double, kFeatures, 1>> x(points[i].data());
    covariance += observed.weight[i] / total * x * x.transpose();
  }
  // Differences below visibility should not matter, and the covariance of a sample is uncertain.
  for (std::size_t k = 0; k < kFeatures; ++k) {
    const Eigen::Index i = k;
    covariance(i, i) = 1.1 * covariance(i, i) + std::pow(kLeastSpread[k] * scale_[k], 2);
  }
  sizes_ = sizes;
  observed_by_area_ = means_by_area(points, observed);
  whitening_ = covariance.llt().matrixL().solve(Matrix::Identity());
  for (std::size_t a = 0; a < kAxes + kDirections; ++a) {
    const auto sorted = along(points, observed.weight, a);
    std::array<double, kQuantiles> q{};
    double reached = 0;
    std::size_t i = 0;
    for (std::size_t k = 0; k < kQuantiles; ++k) {
      const double level = total * (k + 0.5) / kQuantiles;
      while (i + 1 < sorted.size() && reached + sorted[i].second < level) reached += sorted[i++].second;
      q[k] = sorted[i].first;
    }
    quantiles_.push_back(q);
  }
  observed_ = cumulative(observed);
}

std::vector<FeatureTarget::Point> FeatureTarget::standard(const FeatureSample& s) const {
  double mean = 0;
  const double total = total_weight(s);
  for (std::size_t i = 0; i < s.weight.size(); ++i) mean += s.weight[i] * s.root_area[i] / total;
  std::vector<Point> out(s.features.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t k = 0; k < kFeatures; ++k)
      out[i][k] = (s.features[i].values[k] - center_[k]) * scale_[k];
    out[i][kFeatures] = (s.root_area[i] / mean - center_[kFeatures]) * scale_[kFeatures];
  }
  return out;
}

std::vector<std::pair<double, double>> FeatureTarget::along(const std::vector<Point>& points,
                                                            const std::vector<double>& weight,
                                                            std::size_t axis) const {
  std::vector<std::pair<double, double>> out(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    double v = 0;
    if (axis < kAxes) {
      v = points[i][axis];
    } else {
      const Point& d = directions_[axis - kAxes];
      for (std::size_t k = 0; k < kAxes; ++k) v += d[k] * points[i][k];
    }
    out[i] = {v, weight[i]};
  }
  std::sort(out.begin(), out.end());
  return out;
}

Eigen::VectorXd FeatureTarget::means_by_area(const std::vector<Point>& points, const FeatureSample& s) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(kFeatures);
  double total = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = s.weight[i] * s.root_area[i] * s.root_area[i];
    total += w;
    for (std::size_t k = 0; k < kFeatures; ++k) sum[k] += w * std::clamp(points[i][k], -6.0, 6.0);
  }
  return sum / total;
}

double FeatureTarget::distance(const FeatureSample& s) const {
  return s.features.empty() ? 1e6 : residuals(s).squaredNorm();
}

Eigen::VectorXd FeatureTarget::residuals(const FeatureSample& s) const {
  if (s.features.empty()) return {};
  constexpr Eigen::Index kEach = kQuantiles + 1;
  constexpr Eigen::Index kAll = (kAxes + kDirections) * kEach;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(kAll + 2 * kFeatures);
  const auto points = standard(s);
  const double total = total_weight(s);
  Eigen::Matrix<double, kFeatures, 1> mean = Eigen::Matrix<double, kFeatures, 1>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < kFeatures; ++k)
      mean[k] += s.weight[i] / total * std::clamp(points[i][k], -6.0, 6.0);
  out.segment(kAll, kFeatures) = std::sqrt(kToldByMeans) * (whitening_ * mean);
  double importance = 0;
  for (const double w : importance_) importance += w;
  if (sizes_) {
    out.tail(kFeatures) = means_by_area(points, s) - observed_by_area_;
    for (std::size_t k = 0; k < kFeatures; ++k)
      out[kAll + kFeatures + k] *= std::sqrt(kByArea * importance_[k] / importance);
  }
  for (std::size_t a = 0; a < kAxes + kDirections; ++a) {
    const double weight = a < kAxes ? importance_[a] / importance : 1.0 / kDirections;
    if (weight == 0) continue;
    const auto sorted = along(points, s.weight, a);
    const Eigen::Index at = a * kEach;
    double shift = 0, reached = 0;
    std::size_t i = 0;
    for (std::size_t k = 0; k < kQuantiles; ++k) {
      // Interpolate between neighbors, so that the quantiles move smoothly with the body.
      const double level = total * (k + 0.5) / kQuantiles;
      while (i + 1 < sorted.size() && reached + sorted[i].second < level) reached += sorted[i++].second;
      const double t = (level - reached) / sorted[i].second;
      const double below = i > 0 ? (sorted[i - 1].first + sorted[i].first) / 2 : sorted[i].first;
      const double above =
          i + 1 < sorted.size() ? (sorted[i].first + sorted[i + 1].first) / 2 : sorted[i].first;
      const double q = t < 0.5 ? below + 2 * t * (sorted[i].first - below)
                               : sorted[i].first + (2 * t - 1) * (above - sorted[i].first);
      const double d = std::clamp(q - quantiles_[a][k], -6.0, 6.0);
      out[at + k] = std::sqrt(weight / kQuantiles) * d;
      shift += d / kQuantiles;
    }
    // The quantile distance already contains the squared difference of means; means have three times the
    // weight, because an observer of many profiles sees them best.
    out[at + kEach - 1] = std::sqrt(2 * weight) * shift;
  }
  return out;
}

std::vector<double> FeatureTarget::cumulative(const FeatureSample& s) const {
  std::vector<double> out;
  const auto points = standard(s);
  const double total = total_weight(s);
  for (std::size_t a = 0; a < kAxes + kDirections; ++a) {
    const auto sorted = along(points, s.weight, a);
    double below = 0;
    std::size_t i = 0;
    for (std::size_t k = 0; k < kQuantiles; ++k) {
      while (i < sorted.size() && sorted[i].first <= quantiles_[a][k]) below += sorted[i++].second;
      out.push_back(below / total);
    }
    // Append the mean, in units of a standard deviation.
    double mean = 0;
    for (const auto& [v, w] : sorted) mean += std::clamp(v, -6.0, 6.0) * w / total;
    out.push_back(mean);
  }
  return out;
}

std::vector<double> FeatureTarget::importance() const {
  std::vector<double> out;
  for (std::size_t a = 0; a < kAxes + kDirections; ++a) {
    const double w = a < kAxes ? importance_[a] : 0.5;
    for (std::size_t k = 0; k < kQuantiles; ++k) out.push_back(w / kQuantiles);
    out.push_back(w);
  }
  return out;
}

}  // namespace terrazzo::shape_estimate
