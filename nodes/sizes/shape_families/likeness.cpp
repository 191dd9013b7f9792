#include "nodes/sizes/shape_families/likeness.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::shape_families {
namespace {

constexpr double kDeviation = 0.2;    // of the Gaussian, in the logarithm of the size
constexpr double kEqualSizes = 0.05;  // range of logarithms below which sizes count as equal
constexpr std::size_t kNodes = 200;

double gaussian(double z) { return std::exp(-0.5 * z * z); }

}  // namespace

Likeness::Likeness(const Shapes& shapes) {
  double mean = 0, probability = 0;
  for (const Shape& s : shapes.shapes) {
    mean += s.probability * s.size();
    probability += s.probability;
  }
  mean /= probability;
  std::vector<double> logs;
  for (const Shape& s : shapes.shapes) logs.push_back(std::log(s.size() / mean));
  const auto [least, most] = std::minmax_element(logs.begin(), logs.end());
  low_ = *least;
  high_ = *most;
  if (high_ - low_ < kEqualSizes) return;
  for (std::size_t i = 0; i <= kNodes; ++i) {
    const double at = low_ + (high_ - low_) * i / kNodes;
    double sum = 0;
    for (std::size_t k = 0; k < logs.size(); ++k)
      sum += shapes.shapes[k].probability / probability * gaussian((at - logs[k]) / kDeviation);
    normal_.push_back(sum);
  }
}

double Likeness::operator()(double shape_size, double particle_size) const {
  if (normal_.empty()) return 1;
  const double at = std::clamp(std::log(particle_size), low_, high_);
  const double u = (at - low_) / (high_ - low_) * kNodes;
  const auto i = std::min<std::size_t>(u, kNodes - 1);
  const double f = u - i, normal = (1 - f) * normal_[i] + f * normal_[i + 1];
  return gaussian((at - std::log(shape_size)) / kDeviation) / normal;
}

}  // namespace terrazzo::shape_families
