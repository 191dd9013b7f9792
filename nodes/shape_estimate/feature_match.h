// How unlike the profiles of a body are to observed ones.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <vector>

#include "nodes/shape_estimate/section_sample.h"

namespace terrazzo::shape_estimate {

// The joint distribution of observed features, ready for comparison: features in units of their spread (of
// what is just visible where they hardly spread), and their quantiles along the axes and along random
// directions (sliced Wasserstein distance: Rabin, Peyré, Delon, Bernot 2011).
class FeatureTarget {
 public:
  // `sizes`: root areas count too, in units of their mean: for particles that are known to be of one size.
  FeatureTarget(const FeatureSample& observed, bool sizes, std::uint64_t seed);

  // Weighted mean over features of the squared Wasserstein distance of order 2 along each, plus as much of
  // the mean over random directions: 0 where the distributions are one. Differences of means count thrice.
  // And half the squared Mahalanobis distance of the means, which is what Fisher's discriminant could tell a
  // profile by: features vary together, and what breaks that shows although each alone is within its spread.
  double distance(const FeatureSample&) const;
  // That as a sum of squares. Empty where the sample is.
  Eigen::VectorXd residuals(const FeatureSample&) const;

  // Weighted distribution functions of every axis and direction at the observed quantiles, one after the
  // other: what is linear in a mixture's shares.
  std::vector<double> cumulative(const FeatureSample&) const;
  // The same of the observed, and what each entry counts.
  const std::vector<double>& observed_cumulative() const { return observed_; }
  std::vector<double> importance() const;

  double mean_root_area() const { return mean_root_area_; }

 private:
  static constexpr std::size_t kAxes = kOutlineFeatures + 1, kDirections = 20, kQuantiles = 48;
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
  Eigen::Matrix<double, kOutlineFeatures, kOutlineFeatures> whitening_;  // of differences of means
};

}  // namespace terrazzo::shape_estimate
