#include "nodes/sizes/unfold/summary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/stereology/size_kernel.h"

namespace terrazzo::unfold {
namespace {

// The size at which the cumulative sum of `share` passes q; within a class it grows as size^power.
double quantile(const std::vector<double>& edges, const std::vector<double>& share, double q, double power) {
  double below = 0;
  for (std::size_t j = 0; j < share.size(); ++j) {
    if (below + share[j] >= q && share[j] > 0) {
      const double a = std::pow(edges[j], power), b = std::pow(edges[j + 1], power);
      return std::pow(a + (b - a) * (q - below) / share[j], 1 / power);
    }
    below += share[j];
  }
  return edges.back();
}

// Mean over sizes uniform in [a, b] of ln size, and of its square.
struct LogMoments {
  double first, second;
};
LogMoments log_moments(double a, double b) {
  if (!(b - a > 1e-9 * b)) return {std::log(b), std::log(b) * std::log(b)};
  const auto first = [](double x) { return x > 0 ? x * (std::log(x) - 1) : 0; };
  const auto second = [](double x) {
    const double l = x > 0 ? std::log(x) : 0;
    return x > 0 ? x * (l * l - 2 * l + 2) : 0;
  };
  return {(first(b) - first(a)) / (b - a), (second(b) - second(a)) / (b - a)};
}

}  // namespace

SizeSummary summarize(const SizeDistribution& d) {
  SizeSummary s;
  const std::size_t n = d.classes();
  std::vector<double> number(n, 0.0);
  for (const auto& e : d.shapes)
    for (std::size_t j = 0; j < n && j < e.N_V.size(); ++j) number[j] += e.N_V[j];
  s.volume_share.assign(n, 0.0);
  s.volume_passing.assign(n, 0.0);
  for (const double v : number) s.N_V += v;
  if (!(s.N_V > 0)) return s;

  double volume = 0, log_mean = 0, log_square = 0;
  for (std::size_t j = 0; j < n; ++j) {
    const double a = d.class_edges[j], b = d.class_edges[j + 1], share = number[j] / s.N_V;
    const LogMoments m = log_moments(a, b);
    s.mean += share * (a + b) / 2;
    log_mean += share * m.first;
    log_square += share * m.second;
    volume += s.volume_share[j] = number[j] * mean_cube(a, b);
    number[j] = share;
  }
  s.geometric_mean = std::exp(log_mean);
  s.geometric_sd = std::exp(std::sqrt(std::max(0.0, log_square - log_mean * log_mean)));
  double passing = 0;
  for (std::size_t j = 0; j < n; ++j) s.volume_passing[j] = passing += s.volume_share[j] /= volume;
  s.median = quantile(d.class_edges, number, 0.5, 1);
  s.d10 = quantile(d.class_edges, s.volume_share, 0.1, 4);
  s.d50 = quantile(d.class_edges, s.volume_share, 0.5, 4);
  s.d90 = quantile(d.class_edges, s.volume_share, 0.9, 4);
  return s;
}

double equivalent_diameter(const KMatrix& k) {
  double sum = 0, probability = 0;
  for (const auto& e : k.shapes) {
    if (!(e.max_section_area > 0)) continue;
    sum += e.probability * e.volume / std::pow(4 / std::numbers::pi * e.max_section_area, 1.5);
    probability += e.probability;
  }
  return probability > 0 ? std::cbrt(6 / std::numbers::pi * sum / probability) : 0;
}

double sphericity(const KMatrix& k) {
  double sum = 0, probability = 0;
  for (const auto& e : k.shapes) {
    if (!(e.mean_caliper > 0)) continue;
    sum += e.probability * e.volume / (std::numbers::pi / 6 * std::pow(e.mean_caliper, 3));
    probability += e.probability;
  }
  return probability > 0 ? sum / probability : 0;
}

}  // namespace terrazzo::unfold
