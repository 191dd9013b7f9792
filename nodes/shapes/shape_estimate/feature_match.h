// Measures how much the profiles of a body differ from observed ones.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <vector>

#include "nodes/shapes/shape_estimate/section_sample.h"

namespace terrazzo::shape_estimate {

// The joint distribution of observed features, prepared for comparison: features in units of their spread (or
// of a just visible difference, if that is larger), and their quantiles along the axes and along random
// directions (sliced Wasserstein distance: Rabin, Peyré, Delon, Bernot 2011).
class FeatureTarget {
 public:
  // `sizes`: root areas, in units of their mean, are compared too, for particles known to have one size.
  FeatureTarget(const FeatureSample& observed, bool sizes, std::uint64_t seed);

  // Weighted mean over features of the squared Wasserstein distance of order 2 along each, plus the mean
  // over random directions with equal weight; 0 if the distributions are equal. Differences of means
  // have three times the weight. Adds half the squared Mahalanobis distance of the means, by which
  // Fisher's discriminant could distinguish profiles: features are correlated, and a difference that
  // breaks the correlation is visible even if each feature is within its spread. With `sizes`, adds the
  // differences of area-weighted means.
  double distance(const FeatureSample&) const;
  // Vector whose squared norm is the distance. Empty if the sample is empty.
  Eigen::VectorXd residuals(const FeatureSample&) const;

  // Weighted distribution functions of every axis and direction at the observed quantiles, each followed by
  // its mean, concatenated. They are linear in the shares of a mixture.
  std::vector<double> cumulative(const FeatureSample&) const;
  // The same for the observed profiles, and the weight of each entry.
  const std::vector<double>& observed_cumulative() const { return observed_; }
  std::vector<double> importance() const;

  double mean_root_area() const { return mean_root_area_; }

 private:
  static constexpr std::size_t kAxes = kFeatures + 1, kDirections = 20, kQuantiles = 48;
  using Point = std::array<double, kAxes>;
  std::vector<Point> standard(const FeatureSample&) const;
  std::vector<std::pair<double, double>> along(const std::vector<Point>&, const std::vector<double>& weight,
                                               std::size_t axis) const;

  Eigen::VectorXd means_by_area(const std::vector<Point>&, const FeatureSample&) const;

  Point center_{}, scale_{}, importance_{};
  bool sizes_ = false;
  Eigen::VectorXd observed_by_area_;
  double mean_root_area_ = 1;
  std::vector<Point> directions_;
  std::vector<std::array<double, kQuantiles>> quantiles_;  // axes, then directions
  std::vector<double> observed_;
  Eigen::Matrix<double, kFeatures, kFeatures> whitening_;  // whitens differences of means
};

}  // namespace terrazzo::shape_estimate
