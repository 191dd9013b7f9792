// The broad part of a phase's offsets: shading, zones and blotches that are larger than grain.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

constexpr double kBroad = 4;  // standard deviation of the filter that separates it from grain, pixels

// Takes the broad part out of `phases.offset` and returns it: a Gaussian filter over the used pixels of the
// same label.
std::vector<Vec3f> split_broad(Phases&, const Labels&, const Work& = {});

// Covariance of a phase's broad part as a mixture of Gaussians: the field is the sum of white noise filtered
// with each deviation, so sections of the solid have the photograph's covariance.
struct BroadModel {
  Mat3 axes = Mat3::Identity();  // principal axes of the three channels, columns
  std::vector<double> sigma;     // pixels
  std::vector<Vec3> variance;    // of each sigma's field along the axes
};

// Fits the model to pairs of pixels with the same label, up to 48 pixels apart.
BroadModel fit_broad(const std::vector<Vec3f>& broad, const Phases&, const Labels&, int phase,
                     std::uint64_t seed);

// Weights ≥ 0 that minimize |A·w − b|², by cyclic coordinate descent.
Eigen::VectorXd nonnegative_fit(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

// A periodic Gaussian field of size³ voxels with that covariance and mean 0, x fastest.
std::vector<Vec3f> broad_field(const BroadModel&, int size, std::uint64_t seed, const Work& = {});

}  // namespace terrazzo::detail_solid
