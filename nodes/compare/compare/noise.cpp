#include "nodes/compare/compare/noise.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::compare {

bool ComparedNumber::exceeds() const { return std::abs(b - a) > tolerance; }  // false if the tolerance is NaN

void add_color(Comparison& out, const std::string& name, const Vec3f& linear_a, const Vec3f& linear_b,
               const Eigen::Vector3d& lab_a, const Eigen::Vector3d& lab_b, const Eigen::Vector3d& variance) {
  const char* channels[3] = {"L", "a", "b"};
  for (int k = 0; k < 3; ++k)
    out.numbers.push_back({"color", name + " " + channels[k], "Oklab", 0, 0, lab_a[k], lab_b[k],
                           std::max(kVisibleStep, kSigmas95 * std::sqrt(variance[k]))});
  const double delta = (lab_b - lab_a).norm();
  out.numbers.push_back({"color", name + " ΔE", "Oklab", 0, 0, 0, delta,
                         std::max(kVisibleStep, kSigmas95 * std::sqrt(variance.sum()))});
  out.colors.push_back({name, linear_a, linear_b, delta});
  out.metrics["color_difference_" + name] = delta;
}

double earth_mover(std::vector<float> a, std::vector<float> b) {
  if (a.empty() || b.empty()) return 0;
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  // ∫ |Q_a − Q_b|, summed over the steps of both quantile functions.
  double sum = 0, at = 0;
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const double next_a = static_cast<double>(i + 1) / a.size();
    const double next_b = static_cast<double>(j + 1) / b.size();
    const double next = std::min(next_a, next_b);
    sum += (next - at) * std::abs(static_cast<double>(a[i]) - b[j]);
    at = next;
    if (next_a <= next) ++i;
    if (next_b <= next) ++j;
  }
  return sum;
}

}  // namespace terrazzo::compare
