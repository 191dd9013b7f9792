#include "nodes/common/stereology/size_kernel.h"

#include <algorithm>
#include <cmath>

namespace terrazzo {
namespace {

// Between two knots, F = alpha + beta·√(1 − s²).
struct Piece {
  double alpha, beta;
};

Piece piece(const std::vector<double>& cdf, std::size_t b) {
  const double n = cdf.size();
  const double s0 = b / n, s1 = (b + 1) / n;
  const double w0 = std::sqrt(1 - s0 * s0), w1 = b + 1 == cdf.size() ? 0 : std::sqrt(1 - s1 * s1);
  const double f0 = b > 0 ? cdf[b - 1] : 0, f1 = cdf[b];
  const double beta = (f1 - f0) / (w1 - w0);
  return {f0 - beta * w0, beta};
}

// ∫ √(σ² − x²) dσ
double root_integral(double sigma, double x) {
  const double r = std::sqrt(std::max(0.0, sigma * sigma - x * x));
  return (sigma * r - x * x * std::log(sigma + r)) / 2;
}

}  // namespace

double cdf_at(const std::vector<double>& cdf, double s) {
  if (s <= 0 || cdf.empty()) return 0;
  if (s >= 1) return cdf.back();
  const auto b = std::min<std::size_t>(s * cdf.size(), cdf.size() - 1);
  const Piece p = piece(cdf, b);
  return p.alpha + p.beta * std::sqrt(1 - s * s);
}

double mean_scaled_cdf(const std::vector<double>& cdf, double x, double lo, double hi) {
  if (x <= 0 || hi <= 0 || cdf.empty()) return 0;
  if (hi - lo <= 1e-12 * hi) return hi * cdf_at(cdf, x / hi);
  double sum = 0;
  // σ ≤ x: every profile is smaller than x.
  if (lo < x) sum += cdf.back() * (std::min(hi, x) * std::min(hi, x) - lo * lo) / 2;
  // For larger σ, x/σ decreases through the knots.
  const double n = cdf.size();
  double from = std::max(lo, x);
  const auto last = static_cast<std::ptrdiff_t>(cdf.size()) - 1;
  for (auto b = std::min<std::ptrdiff_t>(x / from * n, last); from < hi; --b) {
    const double to = b > 0 ? std::min(hi, x * n / b) : hi;
    if (to <= from) continue;  // `from` is at a knot
    const Piece p = piece(cdf, b);
    sum += p.alpha * (to * to - from * from) / 2 + p.beta * (root_integral(to, x) - root_integral(from, x));
    from = to;
  }
  return sum / (hi - lo);
}

double mean_relative_area(const std::vector<double>& cdf) {
  double sum = 0;
  const double n = cdf.size();
  for (std::size_t b = 0; b < cdf.size(); ++b) {
    // dF = −beta·s/w ds; ∫ s² dF with w = √(1 − s²): −beta·∫ (1 − w²) (−dw) = beta·[w − w³/3]
    const double s0 = b / n, s1 = (b + 1) / n;
    const double w0 = std::sqrt(1 - s0 * s0), w1 = b + 1 == cdf.size() ? 0 : std::sqrt(1 - s1 * s1);
    sum += piece(cdf, b).beta * ((w1 - w1 * w1 * w1 / 3) - (w0 - w0 * w0 * w0 / 3));
  }
  return sum;
}

Eigen::MatrixXd size_kernel(const KMatrix::Entry& shape, const std::vector<double>& profile_edges,
                            const std::vector<double>& size_edges, bool upper_edge) {
  const Eigen::Index rows = profile_edges.size() - 1;
  const Eigen::Index columns = size_edges.size() - 1;
  const double d_max = size_edges.back();
  Eigen::MatrixXd K(rows, columns);
  for (Eigen::Index j = 0; j < columns; ++j) {
    const double hi = size_edges[j + 1], lo = upper_edge ? hi : size_edges[j];
    double before = mean_scaled_cdf(shape.cdf, profile_edges[0], lo, hi);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double after = mean_scaled_cdf(shape.cdf, profile_edges[i + 1], lo, hi);
      K(i, j) = shape.profiles_per_caliper * std::max(0.0, after - before) / d_max;
      before = after;
    }
  }
  return K;
}

std::vector<double> equal_edges(int n, double top) {
  std::vector<double> edges(n + 1);
  for (int i = 0; i <= n; ++i) edges[i] = top * i / n;
  return edges;
}

double mean_cube(double lo, double hi) { return (lo + hi) * (lo * lo + hi * hi) / 4; }

}  // namespace terrazzo
