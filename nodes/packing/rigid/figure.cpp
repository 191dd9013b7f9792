#include "nodes/packing/rigid/figure.h"

#include "nodes/common/plot/plot.h"

namespace terrazzo::packing {
namespace {
double number(const Table::Cell& cell) { return std::get<double>(cell); }
}  // namespace

Plot plot_of_sizes(const Table& sizes, const std::string& requested_name, const std::string& achieved_name) {
  Plot by_size;
  by_size.title = "Particles by size";
  by_size.x_label = "size, mm";
  by_size.y_label = "particles";
  PlotSeries requested, achieved;
  requested.kind = achieved.kind = PlotSeries::Kind::Bars;
  requested.name = requested_name;
  achieved.name = achieved_name;
  achieved.color = 1;
  for (const auto& row : sizes.rows) {
    const double middle = 0.5 * (number(row[0]) + number(row[1]));
    requested.x.push_back(middle);
    requested.y.push_back(number(row[2]));
    achieved.x.push_back(middle);
    achieved.y.push_back(number(row[3]));
  }
  by_size.series = {requested, achieved};
  return by_size;
}

Image figure_of(const Table& sizes, const Table& correlation, const Vec3& sections_per_area) {
  const Plot by_size = plot_of_sizes(sizes, "requested", "achieved");
  Plot pairs;
  pairs.title = "Pair correlation of the centers";
  pairs.x_label = "distance, mm";
  pairs.y_label = "g";
  PlotSeries g;
  for (const auto& row : correlation.rows) {
    g.x.push_back(number(row[0]));
    g.y.push_back(number(row[1]));
  }
  pairs.series = {g};

  Plot cuts;
  cuts.title = "Particles cut by planes";
  cuts.x_label = "across";
  cuts.y_label = "per mm²";
  cuts.x_words = {"x", "y", "z"};
  cuts.width = 360;
  PlotSeries bars;
  bars.kind = PlotSeries::Kind::Bars;
  for (int a = 0; a < 3; ++a) {
    bars.x.push_back(a);
    bars.y.push_back(sections_per_area[a]);
  }
  cuts.series = {bars};
  return draw({by_size, pairs, cuts}, 3);
}

}  // namespace terrazzo::packing
