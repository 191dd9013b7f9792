#include "nodes/unfold/report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "nodes/common/plot.h"

namespace terrazzo {

Table unfold_table(const Unfolding& u) {
  Table t;
  t.columns = {"colour class", "size class",    "lower mm",    "upper mm",    "profiles",
               "N_A per mm²",  "refit per mm²", "N_V per mm³", "low per mm³", "high per mm³"};
  for (std::size_t c = 0; c < u.classes.size(); ++c) {
    const ClassFit& f = u.classes[c];
    for (int j = 0; j < u.model.classes(); ++j) {
      std::vector<Table::Cell> row{static_cast<double>(c), static_cast<double>(j + 1), u.model.edges[j],
                                   u.model.edges[j + 1]};
      for (double v : {f.profiles[j], f.N_A[j], f.refit[j]})
        row.push_back(j < u.model.first ? Table::Cell(std::string("not visible")) : Table::Cell(v));
      for (double v : {f.N_V[j], f.low[j], f.high[j]}) row.emplace_back(v);
      t.rows.push_back(std::move(row));
    }
  }
  return t;
}

Image unfold_figure(const Unfolding& u) {
  std::vector<Plot> plots;
  std::vector<double> middle;
  for (int j = 0; j < u.model.classes(); ++j) middle.push_back((u.model.edges[j] + u.model.edges[j + 1]) / 2);
  const double hidden = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t c = 0; c < std::min<std::size_t>(u.classes.size(), 6); ++c) {
    const ClassFit& f = u.classes[c];
    const std::string name = u.classes.size() > 1 ? fmt::format(", class {}", c) : "";
    std::vector<double> seen = f.N_A, refit = f.refit;
    for (int j = 0; j < u.model.first; ++j) seen[j] = refit[j] = hidden;
    Plot a, v;
    a.title = "Profiles" + name, a.x_label = "size of profile, mm", a.y_label = "N_A per mm²";
    a.series.push_back({PlotSeries::Kind::Bars, "observed", middle, seen, {}, {}, 0});
    a.series.push_back({PlotSeries::Kind::Line, "refit", middle, refit, {}, {}, 1});
    v.title = "Particles" + name, v.x_label = "size of particle, mm", v.y_label = "N_V per mm³";
    PlotSeries bars{PlotSeries::Kind::Bars, "unfolded", middle, f.N_V, {}, {}, 2};
    if (f.low != f.high) bars.low = f.low, bars.high = f.high;
    v.series.push_back(std::move(bars));
    plots.push_back(std::move(a)), plots.push_back(std::move(v));
  }
  return draw(plots, 2);
}

}  // namespace terrazzo
