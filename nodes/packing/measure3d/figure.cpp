#include <algorithm>
#include <cmath>

#include "nodes/common/plot/plot.h"
#include "nodes/data/indices.h"
#include "nodes/packing/measure3d/report.h"

namespace terrazzo::measure3d {
namespace {

using Kind = PlotSeries::Kind;

constexpr double kLeastPath = 1e-5;  // of the lineal path that is shown

PlotSeries series_of(Kind kind, std::string name, int color) {
  PlotSeries s;
  s.kind = kind;
  s.name = std::move(name);
  s.color = color;
  return s;
}

Plot plot_of(const char* title, const char* x, const char* y) {
  Plot p;
  p.title = title;
  p.x_label = x;
  p.y_label = y;
  return p;
}

const Histogram* find(const std::vector<Histogram>& all, const std::string& name) {
  const auto it = std::find_if(all.begin(), all.end(), [&](const Histogram& h) { return h.name == name; });
  return it == all.end() ? nullptr : &*it;
}

PlotSeries bars_of(const Histogram& h, std::string name, int color) {
  PlotSeries s = series_of(Kind::Bars, std::move(name), color);
  for (std::size_t k = 0; k < h.share.size(); ++k) {
    s.x.push_back((h.edges[k] + h.edges[k + 1]) / 2);
    s.y.push_back(h.share[k]);
  }
  return s;
}

void add_particle_plots(const std::vector<Histogram>& all, std::vector<Plot>& plots) {
  if (const Histogram* h = find(all, "diameter")) {
    Plot p = plot_of("Size", "diameter of a sphere of equal volume, mm", "share of particles");
    p.series = {bars_of(*h, "", 0)};
    plots.push_back(p);
  }
  const Histogram *elongation = find(all, "elongation"), *flatness = find(all, "flatness");
  if (elongation && flatness) {
    Plot p = plot_of("Aspect", "ratio of axes", "share of particles");
    p.series = {bars_of(*elongation, "middle / long", 0), bars_of(*flatness, "short / middle", 1)};
    plots.push_back(p);
  }
  Plot orientation = plot_of("Orientation", "|cos| of the longest axis to x, y, z", "relative to random");
  int color = 0;
  for (const Histogram& h : all) {
    if (h.expected.empty()) continue;
    PlotSeries s = series_of(Kind::Line, h.name.substr(h.name.size() - 1), color++);
    for (std::size_t k = 0; k < h.share.size(); ++k) {
      s.x.push_back((h.edges[k] + h.edges[k + 1]) / 2);
      s.y.push_back(h.share[k] / h.expected[k]);
    }
    orientation.series.push_back(s);
  }
  if (!orientation.series.empty()) plots.push_back(orientation);
  if (const Histogram* h = find(all, "contacts")) {
    Plot p = plot_of("Coordination", "contacts of a particle", "share of particles");
    p.series = {bars_of(*h, "", 0)};
    plots.push_back(p);
  }
}

// Share of chords per mm.
PlotSeries chord_curve(const Histogram& h, std::string name, int color) {
  PlotSeries s = series_of(Kind::Line, std::move(name), color);
  for (std::size_t k = 0; k < h.share.size(); ++k) {
    if (!(h.share[k] > 0)) continue;
    s.x.push_back((h.edges[k] + h.edges[k + 1]) / 2);
    s.y.push_back(h.share[k] / (h.edges[k + 1] - h.edges[k]));
  }
  return s;
}

// Share of the volume up to each diameter.
PlotSeries cumulative_curve(const Histogram& h, std::string name, int color) {
  PlotSeries s = series_of(Kind::Line, std::move(name), color);
  double sum = 0;
  for (std::size_t k = 0; k <= h.share.size(); ++k) {
    s.x.push_back(h.edges[k]);
    s.y.push_back(sum);
    if (k < h.share.size()) sum += h.share[k];
  }
  return s;
}

void add_phase_plots(const std::vector<PhaseMeasures>& phases, const std::vector<Histogram>& all,
                     std::vector<Plot>& plots) {
  constexpr int kMostCurves = 6;
  Plot chords = plot_of("Chords of the phase", "length, mm", "share of chords per mm");
  chords.log_y = true;
  for (int a = 0; a < 3; ++a)
    if (const Histogram* h = find(all, std::string("chord along ") + "xyz"[a]))
      chords.series.push_back(chord_curve(*h, std::string(1, "xyz"[a]), a));
  if (!chords.series.empty()) plots.push_back(chords);
  Plot thickness =
      plot_of("Local thickness", "diameter of the largest ball, mm", "share of the phase up to it");
  for (const PhaseMeasures& phase : phases)
    if (const Histogram* h = find(all, "local thickness, phase " + phase.name);
        h && count_of(thickness.series) < kMostCurves)
      thickness.series.push_back(cumulative_curve(*h, phase.name, count_of(thickness.series)));
  if (!thickness.series.empty()) plots.push_back(thickness);
}

void add_correlation_plots(const Correlation& c, std::vector<Plot>& plots) {
  Plot two = plot_of("Two-point correlation", "r, mm", "S2"), path = plot_of("Lineal path", "r, mm", "L");
  path.log_y = true;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::string name(1, "xyz"[a]);
    PlotSeries s = series_of(Kind::Line, name, a), l = s;
    for (std::size_t k = 0; k < c.mean.size(); ++k) {
      const double r = k * c.step;
      s.x.push_back(r);
      s.y.push_back(c.two_point[a][k]);
      if (c.lineal_path[a][k] > kLeastPath) {
        l.x.push_back(r);
        l.y.push_back(c.lineal_path[a][k]);
      }
    }
    two.series.push_back(s);
    path.series.push_back(l);
  }
  PlotSeries mean = series_of(Kind::Line, "all directions", 3);
  mean.x = c.length;
  mean.y = c.mean;
  two.series.push_back(mean);
  plots.push_back(two);
  plots.push_back(path);
}

void add_subvolume_plot(const Representative& r, std::vector<Plot>& plots) {
  if (r.table.empty()) return;
  Plot p = plot_of("Subvolumes", "edge, mm", "standard deviation of the volume fraction");
  p.log_x = p.log_y = true;
  PlotSeries measured = series_of(Kind::Points, "measured", 0),
             expected = series_of(Kind::Line, "from integral range", 1);
  for (const Subvolumes& s : r.table) {
    if (!(s.deviation > 0)) continue;
    measured.x.push_back(s.edge);
    measured.y.push_back(s.deviation);
    measured.low.push_back(std::max(s.deviation - s.error, 0.1 * s.deviation));
    measured.high.push_back(s.deviation + s.error);
    if (s.expected > 0) {
      expected.x.push_back(s.edge);
      expected.y.push_back(s.expected);
    }
  }
  p.series = {measured, expected};
  if (!measured.x.empty()) plots.push_back(p);
}

}  // namespace

Image figure_of(const Findings& f, const std::vector<Histogram>& histograms) {
  std::vector<Plot> plots;
  add_particle_plots(histograms, plots);
  add_phase_plots(f.phases, histograms, plots);
  if (f.correlation && f.phase) add_correlation_plots(*f.correlation, plots);
  if (f.representative) add_subvolume_plot(*f.representative, plots);
  if (plots.empty()) plots.push_back(plot_of("Nothing to show", "", ""));
  return draw(plots, std::min<int>(4, count_of(plots)));
}

}  // namespace terrazzo::measure3d
