#include "nodes/shapes/shape_estimate/methods/spherical_harmonics.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/mesh/convex_hull.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/shape_estimate/methods/arcs.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {

namespace {

using std::numbers::pi;

constexpr int kRays = 256;

// P̄_n^m(x) √((2n+1)/4π (n−m)!/(n+m)!), without the Condon–Shortley phase, for all n ≥ m up to `terms`, by the
// stable recurrence in n. Indexed [m][n].
std::vector<std::vector<double>> legendre(int terms, double x) {
  std::vector<std::vector<double>> p(terms + 1, std::vector<double>(static_cast<std::size_t>(terms) + 1, 0));
  const double s = std::sqrt(std::max(0.0, 1 - x * x));
  double sectoral = std::sqrt(1 / (4 * pi));
  for (int m = 0; m <= terms; ++m) {
    if (m > 0) sectoral *= s * std::sqrt((2 * m + 1.0) / (2 * m));
    p[m][m] = sectoral;
    if (m < terms) p[m][m + 1] = x * std::sqrt(2 * m + 3.0) * sectoral;
    for (int n = m + 2; n <= terms; ++n) {
      const double a = std::sqrt((4.0 * n * n - 1) / (1.0 * n * n - m * m));
      const double b = std::sqrt(((n - 1.0) * (n - 1.0) - m * m) / (4.0 * (n - 1.0) * (n - 1.0) - 1));
      p[m][n] = a * (x * p[m][n - 1] - b * p[m][n - 2]);
    }
  }
  return p;
}

// Evenly spread points and their triangulation.
Mesh sphere(std::size_t points) {
  std::vector<Vec3> at;
  for (std::size_t i = 0; i < points / 2; ++i) {
    at.push_back(half_sphere_direction(i, points / 2));
    at.push_back(-at.back());
  }
  return convex_hull(at);
}

// Radii of an outline about an inner center, at its outermost crossings; this makes any outline star-shaped.
std::vector<double> radii(const Outline& o, const Vec2& center) {
  std::vector<double> angles;
  for (int i = 0; i < kRays; ++i) angles.push_back(2 * pi * i / kRays);
  std::vector<double> r;
  for (const Arc& arc : cut(o, center, angles)) r.push_back(arc.points.front().norm());
  return r;
}

}  // namespace

ProfileSpectrum profile_spectrum(const std::vector<Outline>& profiles, int terms) {
  ProfileSpectrum out;
  out.variance.assign(terms + 1, 0);
  const double count = profiles.size();
  for (const Outline& o : profiles) {
    auto r = radii(o, cut_center(o, {0, pi / 2, pi, 3 * pi / 2}));
    double mean = 0;
    for (const double v : r) mean += v / kRays;
    out.radius += mean / count;
    for (int m = 1; m <= terms; ++m) {
      double c = 0, s = 0;
      for (int i = 0; i < kRays; ++i) {
        c += r[i] / mean * std::cos(2 * pi * m * i / kRays);
        s += r[i] / mean * std::sin(2 * pi * m * i / kRays);
      }
      c *= 2 * pi / kRays / std::sqrt(pi);
      s *= 2 * pi / kRays / std::sqrt(pi);
      out.variance[m] += (s * s + c * c) / (2 * count);
    }
  }
  return out;
}

std::vector<double> equator_weights(int m, int terms) {
  const auto p = legendre(terms, 0);
  std::vector<double> w(terms + 1, 0);
  for (int n = m; n <= terms; ++n) w[n] = 2 * pi * p[m][n] * p[m][n];
  return w;
}

std::vector<double> harmonic_variances(const std::vector<double>& kappa) {
  const int terms = count_of(kappa) - 1;
  std::vector<double> lambda(kappa.size(), 0);
  if (terms < 2) return lambda;
  // The system is upper triangular, but back substitution yields negative variances. Use Lawson and Hanson's
  // nonnegative least squares instead, in relative errors of κ, because variances span orders of magnitude.
  const int n = terms - 1;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b(n);
  double largest = 0;
  for (const double k : kappa) largest = std::max(largest, k);
  for (int m = 2; m <= terms; ++m) {
    const auto w = equator_weights(m, terms);
    const double scale = 1 / std::max(kappa[m], 1e-6 * largest + 1e-300);
    for (int k = m; k <= terms; ++k) a(m - 2, k - 2) = scale * w[k];
    b(m - 2) = scale * kappa[m];
  }
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<char> free(n, 0);
  for (int round = 0; round < 3 * n; ++round) {
    const Eigen::VectorXd gradient = a.transpose() * (b - a * x);
    int best = -1;
    for (int k = 0; k < n; ++k)
      if (!free[k] && gradient[k] > 1e-10 * a.col(k).norm() &&
          (best < 0 || gradient[k] / a.col(k).norm() > gradient[best] / a.col(best).norm()))
        best = k;
    if (best < 0) break;
    free[best] = 1;
    for (int inner = 0; inner < n; ++inner) {
      std::vector<int> set;
      for (int k = 0; k < n; ++k)
        if (free[k]) set.push_back(k);
      Eigen::MatrixXd part(n, count_of(set));
      for (std::size_t k = 0; k < set.size(); ++k) part.col(static_cast<int>(k)) = a.col(set[k]);
      const Eigen::VectorXd y = part.colPivHouseholderQr().solve(b);
      double step = 1;
      for (std::size_t k = 0; k < set.size(); ++k)
        if (y[static_cast<int>(k)] <= 0) {
          const double old = x[set[k]], fall = old - y[static_cast<int>(k)];
          step = std::min(step, fall > 0 ? old / fall : 0);
        }
      for (std::size_t k = 0; k < set.size(); ++k) x[set[k]] += step * (y[static_cast<int>(k)] - x[set[k]]);
      if (step >= 1) break;
      for (const int k : set)
        if (x[k] <= 1e-14) {
          x[k] = 0;
          free[k] = 0;
        }
    }
  }
  for (int k = 0; k < n; ++k) lambda[k + 2] = std::max(0.0, x[k]);
  return lambda;
}

Estimate spherical_harmonics(const EstimateRequest& request, const Work& work) {
  const ProfileSpectrum spectrum = profile_spectrum(request.chosen, kHarmonicTerms);
  const auto lambda = harmonic_variances(spectrum.variance);
  Estimate out;
  out.mesh = sphere(640u << (2 * std::min(request.subdivision, 2)));
  Random random(request.seed, 203, static_cast<std::uint64_t>(request.index));
  std::vector<std::vector<double>> cosine(kHarmonicTerms + 1), sine(kHarmonicTerms + 1);
  for (int n = 0; n <= kHarmonicTerms; ++n)
    for (int m = 0; m <= n; ++m) {
      const double sd = n < 2 ? 0 : std::sqrt(lambda[n]);
      cosine[n].push_back(sd * random.normal());
      sine[n].push_back(m ? sd * random.normal() : 0);
    }
  auto& vertices = out.mesh.vertices;
  std::vector<double> d(vertices.size());
  work.parallel(vertices.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3 u = vertices[v].normalized();
      const auto p = legendre(kHarmonicTerms, u.z());
      const double phi = std::atan2(u.y(), u.x());
      d[v] = 1;
      for (int n = 2; n <= kHarmonicTerms; ++n) {
        if (lambda[n] == 0) continue;
        d[v] += cosine[n][0] * p[0][n];
        for (int m = 1; m <= n; ++m)
          d[v] += std::numbers::sqrt2 * p[m][n] *
                  (cosine[n][m] * std::cos(m * phi) + sine[n][m] * std::sin(m * phi));
      }
    }
  });
  // The model allows negative radii; a body does not.
  for (std::size_t v = 0; v < vertices.size(); ++v)
    vertices[v] = vertices[v].normalized() * (spectrum.radius * std::max(0.05, d[v]));
  out.smooth = true;
  return out;
}

}  // namespace terrazzo::shape_estimate
