// Compares means and distributions of outline features that are invariant to size and position.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/outline_features.h"
#include "nodes/compare/compare/comparison.h"
#include "nodes/compare/compare/noise.h"

namespace terrazzo::compare {
namespace {

constexpr double kSmirnov_95 = 1.3581;  // two-sample Kolmogorov–Smirnov test, 5 % level

struct Sample {
  std::vector<std::pair<double, double>> values;  // value, weight; sorted by value
  double weight = 0, squares = 0, mean = 0, variance = 0;
  double count() const { return squares > 0 ? weight * weight / squares : 0; }  // effective sample size
};

bool is_whole(const Profile& q, double smallest) {
  return !q.touches_border && q.weight > 0 && q.contour.size() >= 12 &&
         std::sqrt(4 * q.area / M_PI) >= smallest;
}

// The median of pixel_step over whole profiles.
double median_step(const Profiles& p, double smallest) {
  std::vector<double> steps;
  for (const Profile& q : p.profiles)
    if (is_whole(q, smallest)) steps.push_back(pixel_step(q.contour));
  return steps.empty() ? 0 : median(std::move(steps));
}

// Uses whole profiles with an outline of at least a dozen points. `blur` in mm.
Sample sample_of(const Profiles& p, OutlineFeature feature, double smallest, double blur) {
  Sample s;
  for (const Profile& q : p.profiles) {
    if (!is_whole(q, smallest)) continue;
    const double share = std::min(0.05, std::hypot(0.01, blur / loop_perimeter(q.contour)));
    const double v = outline_features(q.contour, {.points = 128, .blur = share})[feature];
    if (!std::isfinite(v) || v == 0) continue;
    s.values.emplace_back(v, q.weight);
    s.weight += q.weight;
    s.squares += q.weight * q.weight;
    s.mean += q.weight * v;
  }
  std::sort(s.values.begin(), s.values.end());
  if (s.weight > 0) s.mean /= s.weight;
  for (const auto& [v, w] : s.values) s.variance += w * (v - s.mean) * (v - s.mean) / s.weight;
  return s;
}

// Largest difference between the two cumulative distributions.
double smirnov(const Sample& a, const Sample& b) {
  double below_a = 0, below_b = 0, worst = 0;
  for (std::size_t i = 0, j = 0; i < a.values.size() && j < b.values.size();) {
    const double v = std::min(a.values[i].first, b.values[j].first);
    while (i < a.values.size() && a.values[i].first <= v) below_a += a.values[i++].second / a.weight;
    while (j < b.values.size() && b.values[j].first <= v) below_b += b.values[j++].second / b.weight;
    worst = std::max(worst, std::abs(below_a - below_b));
  }
  return worst;
}

PlotSeries curve(const Sample& s, int color) {
  PlotSeries line;
  line.color = color;
  double below = 0;
  for (const auto& [v, w] : s.values) {
    line.x.push_back(v);
    line.y.push_back(below);
    below += w / s.weight;
    line.x.push_back(v);
    line.y.push_back(std::min(below, 1.0));
  }
  return line;
}

}  // namespace

void compare_outlines(const Profiles& a, const Profiles& b, const std::string& measure, double smallest,
                      Comparison& out) {
  const auto drawn = [](const Profiles& p) {
    return std::any_of(p.profiles.begin(), p.profiles.end(),
                       [](const auto& q) { return !q.contour.empty(); });
  };
  if (!drawn(a) || !drawn(b)) return;  // lists of areas without outlines
  const auto feature =
      measure == "circularity" ? OutlineFeature::Circularity : OutlineFeature::TotalCurvature;
  const std::string unit = measure == "circularity" ? "" : "rad";
  // Hides the steps of pixels and the frays of a segmentation, on both sides alike.
  const double blur = 1.8 * std::max(median_step(a, smallest), median_step(b, smallest));
  const Sample sa = sample_of(a, feature, smallest, blur), sb = sample_of(b, feature, smallest, blur);
  if (sa.values.size() < 2 || sb.values.size() < 2) {
    out.warnings.push_back(fmt::format(
        "{} is not compared: it needs two whole profiles with outlines in both sets; a has {}, b has {}",
        measure, sa.values.size(), sb.values.size()));
    return;
  }
  out.numbers.push_back({measure, "mean", unit, 0, 0, sa.mean, sb.mean,
                         kSigmas95 * std::sqrt(sa.variance / sa.count() + sb.variance / sb.count())});
  out.numbers.push_back({measure, "Kolmogorov–Smirnov distance", "", 0, 0, 0, smirnov(sa, sb),
                         kSmirnov_95 * std::sqrt(1 / sa.count() + 1 / sb.count())});
  out.metrics[measure + "_a"] = sa.mean;
  out.metrics[measure + "_b"] = sb.mean;
  out.metrics[measure + "_distance"] = smirnov(sa, sb);
  Plot plot;
  plot.title = measure == "circularity" ? "Area / perimeter²" : "Total curvature";
  plot.x_label = measure == "circularity" ? "area / perimeter²" : "rad";
  plot.y_label = "share below";
  plot.series = {curve(sa, 0), curve(sb, 1)};
  out.plots.push_back(plot);
}

}  // namespace terrazzo::compare
