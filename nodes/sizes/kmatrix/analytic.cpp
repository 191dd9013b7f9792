#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/sizes/kmatrix/section_statistics.h"

namespace terrazzo::kmatrix {

SectionStatistics ellipsoid_statistics(const Vec3& semi_axes) {
  std::array<double, 3> axis{semi_axes.x(), semi_axes.y(), semi_axes.z()};
  std::sort(axis.begin(), axis.end(), std::greater<>());
  const auto [a, b, c] = axis;
  using std::numbers::pi;

  // The distribution of the half caliper w(u), w² = (a²cos²φ + b²sin²φ)(1 − z²) + c²z², which decreases
  // monotonically with z: exact in z, midpoint rule in φ over the symmetric quarter.
  constexpr int kBins = 4096, kAngles = 512;
  const bool sphere = a - c <= 1e-9 * a;
  const int bins = sphere ? 1 : kBins;
  std::vector<double> share(bins, 0.0), w(bins, (a + c) / 2);
  if (sphere) {
    share[0] = 1;
  } else {
    for (int k = 0; k < bins; ++k) w[k] = c + (a - c) * (k + 0.5) / bins;
    for (int p = 0; p < kAngles; ++p) {
      const double phi = (p + 0.5) / kAngles * pi / 2;
      const double m = a * a * std::cos(phi) * std::cos(phi) + b * b * std::sin(phi) * std::sin(phi);
      double before = 0;
      for (int k = 0; k < bins; ++k) {
        const double edge = c + (a - c) * (k + 1) / bins;
        const double below = m - edge * edge <= 0 ? 1 : 1 - std::sqrt((m - edge * edge) / (m - c * c));
        share[k] += (below - before) / kAngles;
        before = below;
      }
    }
  }
  SectionStatistics s;
  double half_caliper = 0;
  for (int k = 0; k < bins; ++k) half_caliper += share[k] * w[k];
  s.mean_caliper = 2 * half_caliper;
  s.max_section_area = pi * a * b;
  s.volume = 4 * pi / 3 * a * b * c;
  s.cdf.resize(kSectionBins);
  for (int q = 0; q < kSectionBins; ++q) {
    const double r = (q + 1.0) / kSectionBins, t = r * r * s.max_section_area;
    double sum = 0;
    for (int k = 0; k < bins; ++k)
      sum += share[k] * w[k] * (1 - std::sqrt(std::max(0.0, 1 - t * w[k] / (pi * a * b * c))));
    s.cdf[q] = sum / half_caliper;
  }
  s.cdf.back() = 1;
  return s;
}

Vec3 fit_ellipsoid(const Shape& shape) {
  const auto refuse = [&](const std::string& why) {
    return Error("not-an-ellipsoid",
                 fmt::format("\"{}\" is not a sphere, spheroid or ellipsoid: {}", shape.name, why),
                 "use method: slice, which accepts any mesh");
  };
  const auto& v = shape.mesh.vertices;
  if (v.size() < 12) throw refuse(fmt::format("it has only {} vertices", v.size()));
  double scale = 0;
  for (const Vec3& x : v) scale = std::max(scale, x.norm());
  // xᵀMx + g·x = 1 through the vertices, by least squares.
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 1> right = Eigen::Matrix<double, 9, 1>::Zero();
  for (const Vec3& x : v) {
    const Vec3 p = x / scale;
    Eigen::Matrix<double, 9, 1> row;
    row << p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), 2 * p.x() * p.y(), 2 * p.x() * p.z(),
        2 * p.y() * p.z(), p.x(), p.y(), p.z();
    normal += row * row.transpose();
    right += row;
  }
  const Eigen::Matrix<double, 9, 1> q = normal.ldlt().solve(right);
  Mat3 M;
  M << q[0], q[3], q[4], q[3], q[1], q[5], q[4], q[5], q[2];
  const Vec3 g(q[6], q[7], q[8]);
  if (!M.allFinite() || std::abs(M.determinant()) < 1e-12)
    throw refuse("its vertices do not lie on a closed quadric");
  const Vec3 center = -0.5 * M.ldlt().solve(g);
  const double level = 1 + center.dot(M * center);
  const auto eigen = eigen_axes(Mat3(M / level));
  if (!(eigen.eigenvalues().minCoeff() > 0)) throw refuse("its vertices do not lie on an ellipsoid");
  double worst = 0;
  for (const Vec3& x : v) {
    const Vec3 p = x / scale - center;
    worst = std::max(worst, std::abs(std::sqrt(p.dot(M * p) / level) - 1));
  }
  if (!(worst <= 1e-3))
    throw refuse(fmt::format("a vertex is {:.2g} % off the best-fitting ellipsoid", 100 * worst));
  const Vec3 axes =
      scale * eigen.eigenvalues().cwiseInverse().cwiseSqrt();  // increasing eigenvalues: decreasing axes
  const double filled = shape.volume / (4 * std::numbers::pi / 3 * axes.prod());
  if (!(filled >= 0.9))
    throw refuse(fmt::format("it fills only {:.0f} % of the ellipsoid through its vertices", 100 * filled));
  return axes * std::cbrt(filled);
}

}  // namespace terrazzo::kmatrix
