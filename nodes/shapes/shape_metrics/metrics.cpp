#include "nodes/shapes/shape_metrics/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/plot/plot.h"
#include "nodes/data/indices.h"

namespace terrazzo::shape_metrics {

namespace {

constexpr std::size_t kBatch = 1024;  // number of sections whose loops are kept in memory
constexpr auto kCircularity = static_cast<std::size_t>(OutlineFeature::Circularity);
constexpr auto kTotalCurvature = static_cast<std::size_t>(OutlineFeature::TotalCurvature);

// Sums of features, of their squares, and of curvature histograms.
struct Sums {
  std::size_t n = 0;
  std::array<double, kOutlineFeatures> sum{}, square{};
  std::array<double, kCurvatureBins> curvature{};
  Sums operator+(const Sums& o) const {
    Sums s = *this;
    s.n += o.n;
    for (std::size_t k = 0; k < kOutlineFeatures; ++k) {
      s.sum[k] += o.sum[k];
      s.square[k] += o.square[k];
    }
    for (std::size_t b = 0; b < s.curvature.size(); ++b) s.curvature[b] += o.curvature[b];
    return s;
  }
};

void add(Sums& s, const Loop& loop, const OutlineMeasuring& how) {
  const OutlineFeatures f = outline_features(loop, how);
  if (f[OutlineFeature::Circularity] <= 0) return;
  ++s.n;
  for (std::size_t k = 0; k < kOutlineFeatures; ++k) {
    s.sum[k] += f.values[k];
    s.square[k] += f.values[k] * f.values[k];
  }
  for (const double c : outline_curvature(resampled_loop(loop, how.points))) {
    const int bin = round_down((c - kCurvatureFrom) / kCurvatureStep);
    s.curvature[std::clamp(bin, 0, kCurvatureBins - 1)] += 1.0 / how.points;
  }
}

const SectionSummary& of(const MetricsRow& row, bool central) { return central ? row.central : row.random; }

Plot bars(const std::vector<MetricsRow>& rows, std::size_t feature, bool central) {
  Plot p;
  p.title = central ? "through the center" : "random";
  p.y_label = outline_feature_names()[feature];
  PlotSeries s;
  s.kind = PlotSeries::Kind::Bars;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SectionSummary& m = of(rows[i], central);
    p.x_words.push_back(rows[i].name);
    s.x.push_back(static_cast<double>(i));
    s.y.push_back(m.mean[feature]);
    s.low.push_back(m.mean[feature] - m.sd[feature]);
    s.high.push_back(m.mean[feature] + m.sd[feature]);
  }
  p.series.push_back(std::move(s));
  return p;
}

Plot curvatures(const std::vector<MetricsRow>& rows, bool central) {
  Plot p;
  p.title = central ? "curvature, through the center" : "curvature, random";
  p.x_label = "curvature in units of the circle's of equal length";
  p.y_label = "share of the outline";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    PlotSeries s;
    s.name = rows[i].name;
    s.color = i;
    for (int b = 0; b < kCurvatureBins; ++b) {
      s.x.push_back(kCurvatureFrom + (b + 0.5) * kCurvatureStep);
      s.y.push_back(of(rows[i], central).curvature[b]);
    }
    p.series.push_back(std::move(s));
  }
  return p;
}

}  // namespace

SectionSummary summarize(const Shapes& shapes, SectionKind kind, const MetricsOptions& choice,
                         const Work& work) {
  Sums all;
  for (std::size_t first = 0; first < choice.sections; first += kBatch) {
    const std::size_t n = std::min(kBatch, choice.sections - first);
    const double part = 1.0 / choice.sections;
    const Work here = work.part(part * first, part * (first + n));
    const auto sections = random_sections(shapes, n, {kind, choice.seed, first}, here.part(0, 0.6));
    all = here.part(0.6, 1).reduce(
              n, 32, Sums{},
              [&](std::size_t b, std::size_t e) {
                Sums s;
                for (std::size_t i = b; i < e; ++i)
                  for (const auto& profile : sections[i]) add(s, profile[0], choice.measuring);
                return s;
              },
              [](const Sums& a, const Sums& b) { return a + b; }) +
          all;
  }
  if (all.n == 0) throw Error("no-profile", "no section of the shapes has an area", "check the shapes");
  SectionSummary out;
  out.profiles = all.n;
  const double n = all.n;
  for (std::size_t k = 0; k < kOutlineFeatures; ++k) {
    out.mean[k] = all.sum[k] / n;
    out.sd[k] = std::sqrt(std::max(0.0, all.square[k] / n - out.mean[k] * out.mean[k]));
  }
  for (std::size_t b = 0; b < all.curvature.size(); ++b) out.curvature[b] = all.curvature[b] / n;
  return out;
}

Table table_of(const std::vector<MetricsRow>& rows) {
  Table t;
  t.columns = {"name", "sections", "profiles"};
  for (const auto& name : outline_feature_names()) {
    t.columns.push_back(name + " mean");
    t.columns.push_back(name + " sd");
    t.columns.push_back(name + " deviation %");
  }
  for (const bool central : {true, false})
    for (const auto& row : rows) {
      const SectionSummary &m = of(row, central), &first = of(rows[0], central);
      std::vector<Table::Cell> cells{row.name, std::string(central ? "central" : "random"),
                                     static_cast<double>(m.profiles)};
      for (std::size_t k = 0; k < kOutlineFeatures; ++k) {
        cells.emplace_back(m.mean[k]);
        cells.emplace_back(m.sd[k]);
        const double reference = std::abs(first.mean[k]);
        cells.emplace_back(reference > 1e-12 ? 100 * (m.mean[k] - first.mean[k]) / reference : 0.0);
      }
      t.rows.push_back(std::move(cells));
    }
  return t;
}

Image figure_of(const std::vector<MetricsRow>& rows) {
  std::vector<Plot> plots;
  for (const bool central : {true, false})
    for (const std::size_t feature : {kTotalCurvature, kCircularity})
      plots.push_back(bars(rows, feature, central));
  for (const bool central : {true, false}) plots.push_back(curvatures(rows, central));
  return draw(plots, 2);
}

}  // namespace terrazzo::shape_metrics
