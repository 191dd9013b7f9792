#include "nodes/sizes/grain_size/figure.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/plot/plot.h"

namespace terrazzo::grain_size {
namespace {

double phi(double mm) { return -std::log2(mm); }

Plot cumulative_plot(const Sizes& s, Scale scale) {
  Plot plot;
  plot.title = "Grain sizes";
  plot.x_label = scale == Scale::Phi ? "diameter, φ" : "diameter, mm";
  plot.y_label = scale == Scale::Phi ? "coarser, %" : "finer, %";
  plot.log_x = scale == Scale::Mm;
  int color = 0;
  for (const Weighting weighting : kWeightings) {
    const Curve curve = curve_of(s, weighting);
    PlotSeries line;
    line.name = name_of(weighting);
    line.color = color++;
    for (std::size_t i = 0; i < curve.diameter.size(); ++i) {
      line.x.push_back(scale == Scale::Phi ? phi(curve.diameter[i]) : curve.diameter[i]);
      line.y.push_back(100 * (scale == Scale::Phi ? 1 - curve.share[i] : curve.share[i]));
    }
    plot.series.push_back(std::move(line));
  }
  return plot;
}

Plot crystal_plot(const CrystalSizes& crystals) {
  Plot plot;
  plot.title = "Crystal size distribution";
  plot.x_label = "size, mm";
  plot.y_label = crystals.relative ? "ln of relative N_V / class width" : "ln of N_V / class width, mm⁻⁴";
  PlotSeries points{PlotSeries::Kind::Points, "", crystals.size, crystals.density, {}, {}, 0}, line;
  line.color = 1;
  for (const double x : {crystals.size.front(), crystals.size.back()}) {
    line.x.push_back(x);
    line.y.push_back(crystals.intercept + crystals.slope * x);
  }
  plot.series = {points, line};
  return plot;
}

// "major_axis" and 1 → "major axis mm".
std::string with_unit(std::string name, const char* unit) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return *unit ? name + ' ' + unit : name;
}

}  // namespace

Table table_of(const std::vector<Measure>& measures, const CrystalSizes* crystals, Scale scale) {
  Table t;
  t.columns = {"measure", "value", "low", "high", "unit"};
  for (const Measure& m : measures) {
    const bool diameter = m.unit == "mm" && m.name.find("intercept") == std::string::npos;
    // The mean of φ is that of the logarithms.
    const std::string geometric = "geometric ";
    if (!diameter || scale == Scale::Mm)
      t.rows.push_back({m.name, m.value, m.low, m.high, m.unit});
    else if (!m.name.starts_with("mean"))
      t.rows.push_back({m.name.starts_with(geometric) ? m.name.substr(geometric.size()) : m.name,
                        phi(m.value), phi(m.high), phi(m.low), std::string("φ")});
  }
  if (!crystals) return t;
  const auto add = [&](const char* name, double v, const char* unit) {
    t.rows.push_back({std::string(name), v, std::string(), std::string(), std::string(unit)});
  };
  add("slope of the crystal size distribution", crystals->slope, "mm⁻¹");
  if (!crystals->relative) add("intercept of the crystal size distribution", crystals->intercept, "ln mm⁻⁴");
  return t;
}

Image figure_of(const Sizes& s, const CrystalSizes* crystals, Scale scale) {
  if (!crystals) return draw(cumulative_plot(s, scale));
  return draw({cumulative_plot(s, scale), crystal_plot(*crystals)}, 2);
}

Table grains_of(const Profiles& profiles, const std::vector<ProfileColumn>& columns,
                const std::vector<Vec3f>& mean_colors, double pixel_size) {
  Table t;
  t.columns = {"section",       "class",  "area mm²",       "centroid x mm",
               "centroid y mm", "weight", "touches border", "confidence"};
  for (const ProfileColumn& c : columns)
    t.columns.push_back(with_unit(c.name, c.power == 1 ? "mm" : c.name == "orientation" ? "degrees" : ""));
  if (pixel_size > 0) {
    t.columns.emplace_back("area pixels");
    for (const ProfileColumn& c : columns)
      if (c.power == 1) t.columns.push_back(with_unit(c.name, "pixels"));
  }
  if (!mean_colors.empty())
    for (const char* name : {"mean r", "mean g", "mean b"}) t.columns.emplace_back(name);
  const auto add = [](std::vector<Table::Cell>& row, double v) {
    std::isnan(v) ? row.emplace_back(std::string()) : row.emplace_back(v);
  };
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i) {
    const Profile& p = profiles.profiles[i];
    auto& row = t.rows.emplace_back();
    for (const double v : {double(p.section), double(p.cls), p.area, p.centroid.x(), p.centroid.y(), p.weight,
                           double(p.touches_border), p.confidence})
      add(row, v);
    for (const ProfileColumn& c : columns) add(row, c.values[i]);
    if (pixel_size > 0) {
      add(row, p.area / (pixel_size * pixel_size));
      for (const ProfileColumn& c : columns)
        if (c.power == 1) add(row, c.values[i] / pixel_size);
    }
    if (!mean_colors.empty())
      for (int k = 0; k < 3; ++k) add(row, mean_colors[i][k]);
  }
  return t;
}

}  // namespace terrazzo::grain_size
