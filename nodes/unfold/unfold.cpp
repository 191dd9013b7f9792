#include "nodes/unfold/unfold.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "graph/diagnostic.h"
#include "nodes/unfold/bootstrap.h"
#include "nodes/unfold/nnls.h"

namespace terrazzo {
namespace {

// The area fraction's own error, relative: small beside any class's, so that the solid is as full as the
// picture.
constexpr double kFractionError = 0.005;

double condition_of(Eigen::MatrixXd m) {
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    if (const double length = m.col(j).norm(); length > 0) m.col(j) /= length;
  const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(m).singularValues();
  return s[s.size() - 1] > 0 ? s[0] / s[s.size() - 1] : std::numeric_limits<double>::infinity();
}

Eigen::VectorXd solve_inverse(const UnfoldModel& m, const Eigen::VectorXd& density) {
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(m.matrix);
  if (!lu.isInvertible())
    throw Error("singular", "the K matrix of the visible classes cannot be inverted",
                "use fewer classes, a smaller smallest_visible, or method: nnls")
        .parameter("method");
  return lu.solve(density);
}

Eigen::VectorXd solve_nnls(const UnfoldModel& m, const Counts& counts, double area, double area_fraction) {
  const Eigen::Index n = counts.sum.size();
  // A class that shows nothing is known to about one profile of mean weight.
  const double total = counts.sum.sum();
  const double one = total > 0 ? counts.squares.sum() / total : 1;
  Eigen::MatrixXd A(n + 1, n);
  Eigen::VectorXd b(n + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double error = std::sqrt(counts.squares[i] + one * one) / area;
    A.row(i) = m.matrix.row(i) / error;
    b[i] = counts.sum[i] / area / error;
  }
  const double error = kFractionError * std::max(area_fraction, 1e-12);
  A.row(n) = m.volume.transpose() / error;
  b[n] = area_fraction / error;
  // Columns differ by orders of magnitude (a large particle weighs a thousand small ones): scale them to
  // length one.
  const Eigen::VectorXd length = A.colwise().norm().transpose();
  for (Eigen::Index j = 0; j < n; ++j) A.col(j) /= length[j];
  return nnls(A, b).cwiseQuotient(length);
}

}  // namespace

UnfoldResult unfold(const Profiles& profiles, const KMatrix& k, const UnfoldOptions& options,
                    const Work& work) {
  UnfoldResult r;
  const int classes = options.classes > 0 ? options.classes : k.classes;
  double visible = options.smallest_visible;
  if (visible < 0) {
    const Observations all = observe(profiles, options.border, 0, options.area_fraction);
    visible = all.largest;
    for (const auto& c : all.classes)
      for (const double s : c.size) visible = std::min(visible, s);
    visible *= 1 - 1e-9;
  }
  Observations& o = r.observations = observe(profiles, options.border, visible, options.area_fraction);
  if (static_cast<int>(o.used) < 3)
    throw Error("too-few-profiles",
                fmt::format("{} profiles are too few for a distribution of sizes", o.used),
                "use a larger picture, or border: all");
  double d_max = options.d_max;
  if (d_max > 0 && d_max < o.largest * (1 - 1e-9))
    throw Error("too-small",
                fmt::format("the largest profile has the size {:.4g} mm, more than d_max", o.largest),
                "raise d_max, or leave it auto")
        .parameter("d_max");
  if (d_max <= 0) d_max = estimate_d_max(o, k, classes, visible, work.part(0, 0.5));
  UnfoldModel& m = r.model = make_model(k, classes, d_max, visible);
  r.condition = condition_of(m.matrix);

  SizeDistribution& out = r.distribution;
  out.class_edges = m.edges;
  out.d_max = d_max;
  double probability = 0;
  for (const auto& e : k.shapes) probability += e.probability;
  double chi2 = 0;
  int freedom = 0;
  for (std::size_t c = 0; c < o.classes.size(); ++c) {
    const Observation& q = o.classes[c];
    UnfoldFit fit;
    const auto estimate = [&](const std::vector<double>& weights, double area_ratio, double* negative) {
      const Counts counts = count(q.size, weights, m.profile_edges);
      if (options.method == "nnls") return solve_nnls(m, counts, o.area, q.area_fraction * area_ratio);
      Eigen::VectorXd x = solve_inverse(m, counts.sum / o.area);
      if (negative) *negative = x.cwiseMin(0).cwiseAbs().sum() / std::max(x.cwiseAbs().sum(), 1e-300);
      return Eigen::VectorXd(x.cwiseMax(0));
    };
    const Counts counts = count(q.size, q.weight, m.profile_edges);
    fit.density = estimate(q.weight, 1, &fit.negative);
    fit.observed = counts.sum / o.area;
    fit.refitted = m.matrix * fit.density;
    for (Eigen::Index i = 0; i < fit.observed.size(); ++i) {
      const double expected = fit.refitted[i] * o.area;
      if (expected > 0) chi2 += std::pow(counts.sum[i] - expected, 2) / std::max(expected, 1.0), ++freedom;
    }
    freedom -= static_cast<int>((fit.density.array() > 0).count());
    Intervals intervals;
    if (options.bootstrap > 0 && !q.size.empty())
      intervals = bootstrap(
          q, o.sections, options.bootstrap, options.seed, c,
          [&](const std::vector<double>& w, double ratio) { return estimate(w, ratio, nullptr); },
          work.part(0.5, 1));
    out.volume_fraction += m.volume.dot(fit.density);
    for (std::size_t s = 0; s < k.shapes.size(); ++s) {
      const double share = k.shapes[s].probability / probability;
      SizeDistribution::Entry e;
      e.shape = static_cast<int>(s), e.cls = static_cast<int>(c);
      e.N_V.assign(static_cast<std::size_t>(classes), 0);
      for (int j = 0; j < m.visible(); ++j)
        e.N_V[static_cast<std::size_t>(m.first + j)] = share * fit.density[j];
      e.low = e.high = e.N_V;
      for (std::size_t j = 0; j < intervals.low.size(); ++j) {
        e.low[static_cast<std::size_t>(m.first) + j] = share * intervals.low[j];
        e.high[static_cast<std::size_t>(m.first) + j] = share * intervals.high[j];
      }
      out.shapes.push_back(std::move(e));
    }
    r.fits.push_back(std::move(fit));
  }
  out.goodness_of_fit = chi2 / std::max(freedom, 1);
  if (!(out.volume_fraction < 1))
    throw Error(
        "unstable",
        fmt::format(
            "the densities found would fill {:.3g} times the volume: with a condition number of {:.2g} "
            "the counting errors are blown up",
            out.volume_fraction, r.condition),
        options.method == "inverse" ? "use fewer classes, or method: nnls" : "use fewer classes")
        .parameter("classes");
  return r;
}

}  // namespace terrazzo
