// Shared by the comparisons: confidence levels, colors, histogram distance.
#pragma once

#include "nodes/compare/compare/comparison.h"

namespace terrazzo::compare {

constexpr double kSigmas95 = 1.959963984540054;
constexpr double kSigmas90 = 1.6448536269514722;
constexpr double kVisibleStep = 0.02;  // just visible Oklab distance between adjacent colors (Ottosson 2020)

// Adds L, a, b of a color and the distance ΔE, with tolerances from the variances of b − a, at least
// kVisibleStep.
void add_color(Comparison&, const std::string& name, const Vec3f& linear_a, const Vec3f& linear_b,
               const Eigen::Vector3d& lab_a, const Eigen::Vector3d& lab_b, const Eigen::Vector3d& variance);

// Mean difference of the quantiles of two samples. They need not be sorted or equal in size.
double earth_mover(std::vector<float> a, std::vector<float> b);

}  // namespace terrazzo::compare
