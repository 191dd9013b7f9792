#include "nodes/sizes/unfolding/em.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/stereology/size_kernel.h"
#include "nodes/sizes/unfolding/presence.h"

namespace terrazzo::unfolding {
namespace {

// ½·1.645²: the log-likelihood drop at which a one-sided test at 5 % rejects.
constexpr double kDrop = 1.353;

// Weighted profiles carry less information, by the factor Σw²/Σw: counts and exposure are both divided by it.
double mean_weight(const Observation& q) {
  double sum = 0, squares = 0;
  for (const double w : q.weight) {
    sum += w;
    squares += w * w;
  }
  return sum > 0 ? squares / sum : 1;
}

SmoothPoissonProblem problem_of(const EmModel& m, const Observation& q, const std::vector<double>& weights,
                                double area, double area_ratio, double area_error) {
  const double unit = mean_weight(q);
  SmoothPoissonProblem p;
  p.place = m.place;
  p.A = m.fine * m.width.asDiagonal() * (area / unit);
  p.counts = count(q.size, weights, m.profiles).sum / unit;
  if (const double fraction = q.area_fraction * area_ratio; fraction > 0) {
    p.total = m.volume.cwiseProduct(m.width);
    p.known_total = fraction;
    p.known_error = area_error;
  }
  return p;
}

}  // namespace

EmModel make_em_model(const KMatrix& k, const UnfoldModel& model, Bed bed) {
  EmModel m;
  const int classes = model.visible();
  const int parts = std::clamp(40 / classes, 2, 20), bins = classes * parts;
  const double lo = model.profile_edges.front(), hi = model.profile_edges.back();
  for (int i = 0; i < classes; ++i)
    for (int k = 0; k < parts; ++k)
      m.sizes.push_back(model.profile_edges[i] +
                        (model.profile_edges[i + 1] - model.profile_edges[i]) * k / parts);
  m.sizes.push_back(hi);
  const int rows = std::clamp(3 * classes, 60, 240);
  for (int i = 0; i <= rows; ++i) m.profiles.push_back(i == rows ? hi : lo + (hi - lo) * i / rows);
  m.fine = model_matrix(k, m.profiles, m.sizes, false, bed);
  m.coarse = model_matrix(k, model.profile_edges, m.sizes, false, bed);
  m.reclass = Eigen::MatrixXd::Zero(classes, bins);
  m.width.resize(bins);
  m.place.resize(bins);
  for (int j = 0; j < bins; ++j) {
    const double a = m.sizes[j], b = m.sizes[j + 1];
    m.width[j] = (b - a) * bins / (hi - lo);
    m.place[j] = (std::sqrt((a + b) / 2) - std::sqrt(lo)) / (std::sqrt(hi) - std::sqrt(lo));
    m.reclass(j / parts, j) = 1;
    m.cls.push_back(j / parts);
  }
  m.volume = m.reclass.transpose() * model.volume;
  return m;
}

EmFit fit_em(const EmModel& m, const Observation& q, double area, double area_error, const Work& work) {
  EmFit fit;
  if (q.size.empty()) {
    fit.density = Eigen::VectorXd::Zero(m.width.size());
    return fit;
  }
  fit.fits = smooth_poisson_fits(problem_of(m, q, q.weight, area, 1, area_error), work);
  fit.density = m.width.cwiseProduct(mean_density(fit.fits));
  return fit;
}

Eigen::VectorXd draw_em(const EmModel& m, const EmFit& fit, const Observation& q,
                        const std::vector<double>& weights, double area, double area_ratio, double area_error,
                        Random& random) {
  return m.reclass * m.width.cwiseProduct(draw_density(
                         problem_of(m, q, weights, area, area_ratio, area_error), fit.fits, random));
}

std::vector<char> may_be_empty(const EmModel& m, const EmFit& fit, const Observation& q, double area,
                               const Work& work) {
  const double unit = mean_weight(q);
  return may_be_empty(m.fine * (area / unit), count(q.size, q.weight, m.profiles).sum / unit, m.cls,
                      fit.density, kDrop, work);
}

}  // namespace terrazzo::unfolding
