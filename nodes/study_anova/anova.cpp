#include "nodes/study_anova/anova.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "graph/diagnostic.h"

namespace terrazzo::study_anova {

namespace {

// Lentz's continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  double c = 1, d = 1 - (a + b) * x / (a + 1);
  d = 1 / (std::abs(d) < kTiny ? kTiny : d);
  double h = d;
  for (int m = 1; m <= 500; ++m) {
    for (const double term : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                              -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1 + term * d;
      d = 1 / (std::abs(d) < kTiny ? kTiny : d);
      c = 1 + term / c;
      if (std::abs(c) < kTiny) c = kTiny;
      h *= c * d;
      if (std::abs(c * d - 1) < 1e-15) return h;
    }
  }
  return h;
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  return x < (a + 1) / (a + b + 2) ? front * beta_fraction(a, b, x) / a
                                   : 1 - front * beta_fraction(b, a, 1 - x) / b;
}

std::vector<std::string> levels(const std::vector<std::string>& v) {
  std::vector<std::string> out = v;
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Residual sum of squares and rank of a model.
struct Model {
  double squares;
  double rank;
};
Model fit(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr(x);
  return {(y - x * qr.solve(y)).squaredNorm(), static_cast<double>(qr.rank())};
}

}  // namespace

double f_tail(double f, double a, double b) {
  return f <= 0 ? 1 : incomplete_beta(b / 2, a / 2, b / (b + a * f));
}

std::vector<Effect> two_way(const std::vector<double>& value, const std::vector<std::string>& method,
                            const std::vector<std::string>& shape) {
  const auto n = static_cast<Eigen::Index>(value.size());
  const auto methods = levels(method), shapes = levels(shape);
  const Eigen::Map<const Eigen::VectorXd> y(value.data(), n);
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(n, 1);
  std::vector<Effect> out;
  Model before = fit(x, y);
  const auto add = [&](const std::string& name, const Eigen::MatrixXd& columns) {
    Eigen::MatrixXd wider(n, x.cols() + columns.cols());
    wider << x, columns;
    const Model now = fit(wider, y);
    if (now.rank > before.rank)
      out.push_back({name, std::max(0.0, before.squares - now.squares), now.rank - before.rank});
    x = std::move(wider), before = now;
  };
  const auto dummies = [&](const std::vector<std::string>& v, const std::vector<std::string>& all) {
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(all.size()));
    for (Eigen::Index i = 0; i < n; ++i)
      m(i, std::lower_bound(all.begin(), all.end(), v[static_cast<std::size_t>(i)]) - all.begin()) = 1;
    return m;
  };
  std::vector<std::string> cell;
  for (std::size_t i = 0; i < value.size(); ++i) cell.push_back(method[i] + "\n" + shape[i]);
  add("method", dummies(method, methods));
  add("shape", dummies(shape, shapes));
  add("method × shape", dummies(cell, levels(cell)));
  const double freedom = static_cast<double>(n) - before.rank;
  if (freedom < 1)
    throw Error(
        "too-few-answers",
        fmt::format("{} answers for {} effects leave no degrees of freedom for the residual", n, before.rank),
        "add the answers of more participants");
  const double mean = before.squares / freedom;
  for (auto& e : out) {
    e.f = mean > 0 ? e.squares / e.freedom / mean : std::numeric_limits<double>::infinity();
    e.p = std::isfinite(e.f) ? f_tail(e.f, e.freedom, freedom) : 0;
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  out.push_back({"residual", before.squares, freedom, nan, nan});
  return out;
}

}  // namespace terrazzo::study_anova
