#include "nodes/shapes/shape_estimate/methods/swelling.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/directions.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {

namespace {

using std::numbers::pi;

constexpr int kMostDegrees = 6;

}  // namespace

void harmonics(const Vec3& u, int degrees, double* out) {
  double p[kMostDegrees + 1][kMostDegrees + 1] = {};
  const double s = std::sqrt(std::max(0.0, 1 - u.z() * u.z()));
  double sectoral = 1;
  for (int m = 0; m <= degrees; ++m) {
    if (m > 0) sectoral *= s * std::sqrt((2 * m + 1.0) / (2 * m));
    p[m][m] = sectoral;
    if (m < degrees) p[m][m + 1] = u.z() * std::sqrt(2 * m + 3.0) * sectoral;
    for (int n = m + 2; n <= degrees; ++n) {
      const double a = std::sqrt((4.0 * n * n - 1) / (1.0 * n * n - m * m));
      const double b = std::sqrt(((n - 1.0) * (n - 1.0) - m * m) / (4.0 * (n - 1.0) * (n - 1.0) - 1));
      p[m][n] = a * (u.z() * p[m][n - 1] - b * p[m][n - 2]);
    }
  }
  const double phi = std::atan2(u.y(), u.x());
  int k = 0;
  for (int n = 2; n <= degrees; ++n) {
    out[k++] = p[0][n];
    for (int m = 1; m <= n; ++m) {
      out[k++] = std::numbers::sqrt2 * p[m][n] * std::cos(m * phi);
      out[k++] = std::numbers::sqrt2 * p[m][n] * std::sin(m * phi);
    }
  }
}

Fields::Fields(std::uint64_t seed) {
  constexpr double kLength[kCount][2] = {{1.0, 1.6}, {0.55, 0.9}, {0.35, 0.55}, {0.22, 0.35}};
  for (int k = 0; k < kCount; ++k) {
    Random r(seed, 207, static_cast<std::uint64_t>(k));
    for (int w = 0; w < kWaves; ++w) {
      wave_[k][w] = random_direction(r) * (2 * pi / r.uniform(kLength[k][0], kLength[k][1]));
      phase_[k][w] = 2 * pi * r.uniform();
    }
  }
}

double Fields::operator()(int k, const Vec3& u) const {
  double sum = 0;
  for (int w = 0; w < kWaves; ++w) sum += std::cos(wave_[k][w].dot(u) + phase_[k][w]);
  return sum / std::sqrt(kWaves / 2.0);
}

std::vector<Vec3> spread_directions(std::uint64_t seed, int count) {
  Random r(seed, 209);
  std::vector<Vec3> out;
  double apart = 1.7 * std::sqrt(4 * pi / count) / 2;
  for (int tries = 0; count_of(out) < count; ++tries) {
    if (tries % 100 == 99) apart *= 0.93;
    const Vec3 d = random_direction(r);
    if (std::all_of(out.begin(), out.end(),
                    [&](const Vec3& m) { return std::acos(std::clamp(m.dot(d), -1.0, 1.0)) > apart; }))
      out.push_back(d);
  }
  return out;
}

double bounded(double v, double most) { return most * std::tanh(v / most); }

}  // namespace terrazzo::shape_estimate
