#include "nodes/common/statistics/anova.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace terrazzo {

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

// Sums of squares below this share of Σ value² are rounding errors of values that do not vary.
constexpr double kRounding = 1e-12;

void complete(AnovaEffect& e, double scale) {
  if (e.squares < kRounding * scale) e.squares = 0;
  if (e.error_squares < kRounding * scale) e.error_squares = 0;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (e.error_freedom < 1) {
    e.f = e.p = e.corrected_p = nan;
  } else if (e.error_squares > 0) {
    e.f = e.squares / e.freedom / (e.error_squares / e.error_freedom);
    e.p = f_tail(e.f, e.freedom, e.error_freedom);
    e.corrected_p = f_tail(e.f, e.epsilon * e.freedom, e.epsilon * e.error_freedom);
  } else if (e.squares > 0) {
    e.f = std::numeric_limits<double>::infinity();
    e.p = e.corrected_p = 0;
  } else {
    e.f = e.p = e.corrected_p = nan;
  }
}

std::vector<std::string> levels(const std::vector<AnovaCell>& cells, std::string AnovaCell::*factor) {
  std::vector<std::string> out;
  for (const auto& c : cells) out.push_back(c.*factor);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Residual sum of squares of the cells' means, and rank, of a model.
struct Model {
  double squares;
  double rank;
};

Model fit(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr(x);
  return {(y - x * qr.solve(y)).squaredNorm(), static_cast<double>(qr.rank())};
}

// Adds groups of columns to a model of the cells, one after the other; each is an effect.
std::vector<AnovaEffect> sequential(const std::vector<AnovaCell>& cells,
                                    const std::vector<std::pair<std::string, Eigen::MatrixXd>>& groups) {
  const Eigen::Index rows = cells.size();
  Eigen::VectorXd weight(rows), y(rows);
  double n = 0, within = 0, scale = 0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const AnovaCell& c = cells[i];
    weight(i) = std::sqrt(c.n);
    y(i) = weight(i) * c.mean;
    n += c.n;
    within += c.squares;
    scale += c.n * c.mean * c.mean + c.squares;
  }
  Eigen::MatrixXd x = weight;
  Model before = fit(x, y);
  std::vector<AnovaEffect> out;
  for (const auto& [name, columns] : groups) {
    Eigen::MatrixXd wider(rows, x.cols() + columns.cols());
    wider << x, weight.asDiagonal() * columns;
    const Model now = fit(wider, y);
    if (now.rank > before.rank) {
      AnovaEffect e;
      e.name = name;
      e.squares = std::max(0.0, before.squares - now.squares);
      e.freedom = now.rank - before.rank;
      out.push_back(std::move(e));
    }
    x = std::move(wider);
    before = now;
  }
  const double freedom = std::max(0.0, n - before.rank);
  for (auto& e : out) {
    e.error_squares = before.squares + within;
    e.error_freedom = freedom;
    complete(e, scale);
  }
  return out;
}

Eigen::MatrixXd dummies(const std::vector<AnovaCell>& cells, std::string AnovaCell::*factor) {
  const auto all = levels(cells, factor);
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(cells.size(), all.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    m(i, std::lower_bound(all.begin(), all.end(), cells[i].*factor) - all.begin()) = 1;
  return m;
}

// n − 1 orthonormal contrasts of n levels as columns (Helmert).
Eigen::MatrixXd contrasts(int n) {
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(n, n - 1);
  for (int k = 1; k < n; ++k) {
    c.col(k - 1).head(k).setConstant(1 / std::sqrt(k * (k + 1.0)));
    c(k, k - 1) = -k / std::sqrt(k * (k + 1.0));
  }
  return c;
}

Eigen::MatrixXd kronecker(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd out(a.rows() * b.rows(), a.cols() * b.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < a.cols(); ++j)
      out.block(i * b.rows(), j * b.cols(), b.rows(), b.cols()) = a(i, j) * b;
  return out;
}

}  // namespace

double f_tail(double f, double a, double b) {
  return f <= 0 ? 1 : incomplete_beta(b / 2, a / 2, b / (b + a * f));
}

std::vector<AnovaCell> anova_cells(const std::vector<double>& value, const std::vector<std::string>& a,
                                   const std::vector<std::string>& b) {
  std::map<std::pair<std::string, std::string>, AnovaCell> cells;
  for (std::size_t i = 0; i < value.size(); ++i) {
    AnovaCell& c = cells[{a[i], b[i]}];
    c.a = a[i];
    c.b = b[i];
    // Welford's update.
    const double off = value[i] - c.mean;
    c.mean += off / ++c.n;
    c.squares += off * (value[i] - c.mean);
  }
  std::vector<AnovaCell> out;
  for (auto& [key, cell] : cells) out.push_back(std::move(cell));
  return out;
}

std::vector<AnovaEffect> two_way_anova(const std::vector<AnovaCell>& cells, const AnovaFactors& factors) {
  const Eigen::Index n = cells.size();
  return sequential(cells, {{factors[0], dummies(cells, &AnovaCell::a)},
                            {factors[1], dummies(cells, &AnovaCell::b)},
                            {factors[0] + " × " + factors[1], Eigen::MatrixXd::Identity(n, n)}});
}

std::vector<AnovaEffect> one_way_anova(const std::vector<AnovaCell>& cells, const AnovaFactors& factors) {
  return sequential(cells, {{factors[0], dummies(cells, &AnovaCell::a)}});
}

std::vector<AnovaEffect> repeated_anova(const Eigen::MatrixXd& values, int levels_a, int levels_b,
                                        const AnovaFactors& factors) {
  const double people = values.rows();
  const Eigen::MatrixXd mean_a = Eigen::MatrixXd::Constant(levels_a, 1, 1 / std::sqrt(levels_a)),
                        mean_b = Eigen::MatrixXd::Constant(levels_b, 1, 1 / std::sqrt(levels_b));
  const std::vector<std::pair<std::string, Eigen::MatrixXd>> effects{
      {factors[0], kronecker(contrasts(levels_a), mean_b)},
      {factors[1], kronecker(mean_a, contrasts(levels_b))},
      {factors[0] + " × " + factors[1], kronecker(contrasts(levels_a), contrasts(levels_b))}};
  std::vector<AnovaEffect> out;
  for (const auto& [name, contrast] : effects) {
    if (contrast.cols() == 0) continue;
    const Eigen::MatrixXd z = values * contrast;  // the effect's contrasts, for each person
    const Eigen::RowVectorXd mean = z.colwise().mean();
    const Eigen::MatrixXd off = z.rowwise() - mean;
    const Eigen::MatrixXd covariance = off.transpose() * off;  // times people − 1
    AnovaEffect e;
    e.name = name;
    e.freedom = contrast.cols();
    e.error_freedom = e.freedom * (people - 1);
    e.squares = people * mean.squaredNorm();
    e.error_squares = off.squaredNorm();
    const double trace = covariance.trace();
    if (trace > 0) e.epsilon = std::min(1.0, trace * trace / (e.freedom * covariance.squaredNorm()));
    complete(e, values.squaredNorm());
    out.push_back(std::move(e));
  }
  return out;
}

}  // namespace terrazzo
