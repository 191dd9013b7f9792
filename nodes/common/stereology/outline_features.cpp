#include "nodes/common/stereology/outline_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/loop_moments.h"
#include "nodes/data/indices.h"

namespace terrazzo {

namespace {

using std::numbers::pi;
using Points = std::vector<Vec2>;

// Circular Gaussian blur of evenly spaced points. It scales the outline, which does not affect the features.
Points blurred(const Points& p, double sigma_points) {
  const int n = p.size(), reach = std::min(n / 2, round_up(3 * sigma_points));
  std::vector<double> weight(reach + 1);
  double sum = 0;
  for (int k = 0; k <= reach; ++k) {
    weight[k] = std::exp(-0.5 * (k / sigma_points) * (k / sigma_points));
    sum += (k ? 2 : 1) * weight[k];
  }
  for (double& w : weight) w /= sum;
  Points around;  // p with `reach` more points on either side
  around.reserve(p.size() + 2 * static_cast<std::size_t>(reach));
  around.insert(around.end(), p.end() - reach, p.end());
  around.insert(around.end(), p.begin(), p.end());
  around.insert(around.end(), p.begin(), p.begin() + reach);
  Points out(p.size(), Vec2::Zero());
  for (int i = 0; i < n; ++i) {
    const Vec2* middle = around.data() + i + reach;
    for (int k = -reach; k <= reach; ++k) out[i] += weight[std::abs(k)] * middle[k];
  }
  return out;
}

// An outline z(s) is mirror-symmetric if z(s₀ − s)* = e^{iφ} z(s) for some s₀ and φ. The rms distance for the
// best s₀ and φ follows from the maximum of |Σ z(s) z(s₀ − s)|.
double symmetry_of(const Points& p) {
  constexpr std::size_t kPoints = 32;  // axes are resolved to 1/64 of the outline
  const std::size_t n = std::min(kPoints, p.size());
  std::array<double, kPoints> x{}, y{};
  std::array<double, 2 * kPoints> back_x{}, back_y{};  // z(−s), over two periods
  Vec2 mean = Vec2::Zero();
  for (std::size_t i = 0; i < n; ++i) mean += p[i * p.size() / n] / static_cast<double>(n);
  double square = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 q = p[i * p.size() / n] - mean;
    x[i] = q.x();
    y[i] = q.y();
    square += q.squaredNorm();
    for (const std::size_t k : {n - i, (2 * n - i) % (2 * n)}) {
      back_x[k] = q.x();
      back_y[k] = q.y();
    }
  }
  double best = 0;
  for (std::size_t s = 0; s < n; ++s) {
    double re = 0, im = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = i + n - s;  // z(s − i)
      re += x[i] * back_x[k] - y[i] * back_y[k];
      im += x[i] * back_y[k] + y[i] * back_x[k];
    }
    best = std::max(best, re * re + im * im);
  }
  return 1 - std::sqrt(std::max(0.0, 2 - 2 * std::sqrt(best) / square));
}

double anisotropy_of(const Points& p) {
  double xx = 0, yy = 0, xy = 0, length = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec2 d = p[(i + 1) % p.size()] - p[i];
    const double l = d.norm();
    if (l == 0) continue;
    xx += d.x() * d.x() / l;
    yy += d.y() * d.y() / l;
    xy += d.x() * d.y() / l;
    length += l;
  }
  return length > 0 ? 2 * std::hypot((xx - yy) / 2, xy) / length : 0;
}

// The angle between two directions, cheaper than its arc tangent and in the same order: −2 … 2.
double order_of_turn(const Vec2& before, const Vec2& after) {
  const double c = cross(before, after), d = before.dot(after), sum = std::abs(c) + std::abs(d);
  if (sum == 0) return 0;
  return d >= 0 ? c / sum : (c < 0 ? -1 - -d / sum : 1 + -d / sum);
}

std::size_t arms_of(std::size_t points) { return std::max<std::size_t>(1, points / 32); }

// A circle turns by 2π·arms/n.
double per_circle(std::size_t points, std::size_t arms) { return points / (2 * pi * arms); }

// Turning angle of the outline over `arms` steps on either side of each point.
std::vector<double> turns_over(const Points& p, std::size_t arms) {
  const std::size_t n = p.size();
  std::vector<double> out(n);
  for (std::size_t i = 0; i < n; ++i)
    out[i] = turn_between(p[i] - p[(i + n - arms) % n], p[(i + arms) % n] - p[i]);
  return out;
}

// Quantiles of outline_curvature.
void set_curvature(OutlineFeatures& f, const Points& p) {
  const std::size_t n = p.size(), arms = arms_of(n);
  std::vector<std::pair<double, std::size_t>> order(n);
  const auto before = [&](std::size_t i) -> Vec2 { return p[i] - p[i >= arms ? i - arms : i + n - arms]; };
  const auto after = [&](std::size_t i) -> Vec2 { return p[i + arms < n ? i + arms : i + arms - n] - p[i]; };
  for (std::size_t i = 0; i < n; ++i) order[i] = {order_of_turn(before(i), after(i)), i};
  const auto set = [&](OutlineFeature feature, double q) {
    const std::ptrdiff_t k = q * (n - 1) + 0.5;
    std::nth_element(order.begin(), order.begin() + k, order.end());
    const std::size_t i = order[k].second;
    f.values[static_cast<std::size_t>(feature)] = turn_between(before(i), after(i)) * per_circle(n, arms);
  };
  set(OutlineFeature::CurvatureLow, 0.1);
  set(OutlineFeature::CurvatureMedian, 0.5);
  set(OutlineFeature::CurvatureHigh, 0.9);
}

void add_corners(OutlineFeatures& f, const Points& p, const std::vector<double>& turns) {
  const std::size_t n = p.size(), arc = std::max<std::size_t>(1, (n + 12) / 24);
  std::vector<double> within(n, 0);
  double sum = 0;
  for (std::size_t k = 0; k < arc; ++k) sum += turns[k];
  for (std::size_t i = 0; i < n; ++i) {
    within[i] = sum;
    sum += turns[(i + arc) % n] - turns[i];
  }
  const double share = static_cast<double>(n) / 24 / arc;  // arcs are whole steps
  double most = 0;
  int corners = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = std::abs(within[i]) * share;
    most = std::max(most, w);
    if (w < pi / 6) continue;
    bool peak = true;
    for (std::size_t k = 1; peak && k < arc; ++k)
      peak = std::abs(within[(i + n - k) % n]) < std::abs(within[i]) &&
             std::abs(within[(i + k) % n]) <= std::abs(within[i]);
    corners += peak;
  }
  f.values[static_cast<std::size_t>(OutlineFeature::Corner)] = most * 180 / pi;
  f.values[static_cast<std::size_t>(OutlineFeature::Corners)] = corners;
}

}  // namespace

const std::array<std::string, kOutlineFeatures>& outline_feature_names() {
  static const std::array<std::string, kOutlineFeatures> names{"area/perimeter²",
                                                               "total curvature rad",
                                                               "aspect",
                                                               "convexity",
                                                               "sharpest corner degrees",
                                                               "corners",
                                                               "symmetry",
                                                               "anisotropy",
                                                               "curvature 10%",
                                                               "curvature median",
                                                               "curvature 90%"};
  return names;
}

std::vector<Vec2> resampled_loop(const Loop& loop, int points) {
  const std::size_t n = loop.size();
  std::vector<double> at(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) at[i + 1] = at[i] + (loop[(i + 1) % n] - loop[i]).norm();
  Points out(static_cast<std::size_t>(points), n ? loop[0] : Vec2(0, 0));
  if (!(at[n] > 0)) return out;
  std::size_t i = 0;
  for (int k = 0; k < points; ++k) {
    const double s = at[n] * k / points;
    while (i + 1 < n && at[i + 1] <= s) ++i;
    const double step = at[i + 1] - at[i], t = step > 0 ? (s - at[i]) / step : 0;
    out[k] = (1 - t) * loop[i] + t * loop[(i + 1) % n];
  }
  return out;
}

double pixel_step(const Loop& loop) {
  if (loop.empty()) return 0;
  std::vector<double> steps;
  for (std::size_t i = 0; i < loop.size(); ++i)
    steps.push_back((loop[(i + 1) % loop.size()] - loop[i]).norm());
  std::sort(steps.begin(), steps.end());
  const double median = steps[steps.size() / 2];
  return steps[steps.size() - 1 - steps.size() / 50] < 2 * median ? median : 0;
}

std::vector<double> outline_curvature(const std::vector<Vec2>& p) {
  const std::size_t arms = arms_of(p.size());
  auto turns = turns_over(p, arms);
  for (double& t : turns) t *= per_circle(p.size(), arms);
  return turns;
}

std::vector<Vec2> measured_points(const Loop& loop, const OutlineMeasuring& how) {
  if (loop.size() < 3) return {};
  Points p = resampled_loop(loop, how.points);
  return how.blur > 0 ? blurred(p, how.blur * how.points) : p;
}

OutlineFeatures outline_features(const Loop& loop, const OutlineMeasuring& how) {
  return outline_features_of(measured_points(loop, how));
}

OutlineFeatures outline_features_of(const std::vector<Vec2>& p) {
  OutlineFeatures f;
  if (p.empty()) return f;
  const LoopMoments m = loop_moments(p);
  if (!(m.area > 0) || !(m.longer > 0)) return f;
  double length = 0;
  for (std::size_t i = 0; i < p.size(); ++i) length += (p[(i + 1) % p.size()] - p[i]).norm();
  const auto set = [&](OutlineFeature k, double v) { f.values[static_cast<std::size_t>(k)] = v; };
  set(OutlineFeature::Circularity, m.area / (length * length));
  const auto turns = turns_over(p, 1);
  double total = 0;
  for (const double t : turns) total += std::abs(t);
  set(OutlineFeature::TotalCurvature, total);
  set(OutlineFeature::Aspect, std::sqrt(m.shorter / m.longer));
  set(OutlineFeature::Convexity, std::min(1.0, m.area / hull_area(p)));
  add_corners(f, p, turns);
  set(OutlineFeature::Symmetry, symmetry_of(p));
  set(OutlineFeature::Anisotropy, anisotropy_of(p));
  set_curvature(f, p);
  return f;
}

}  // namespace terrazzo
