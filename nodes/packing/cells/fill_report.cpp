#include <cmath>
#include <numbers>

#include "nodes/common/plot/plot.h"
#include "nodes/packing/cells/fill_space.h"
#include "nodes/packing/rigid/figure.h"
#include "nodes/packing/rigid/statistics.h"

namespace terrazzo::tessellation {
namespace {

// Surface of the ball of equal volume, relative to the surface (Wadell 1932).
double sphericity(const Shape& s) {
  return std::cbrt(std::numbers::pi) * std::pow(6 * s.volume, 2.0 / 3) / s.surface_area;
}

PlotSeries histogram(const std::vector<double>& values, double low, double high, int bins) {
  PlotSeries bars;
  bars.kind = PlotSeries::Kind::Bars;
  bars.y.assign(bins, 0);
  for (int k = 0; k < bins; ++k) bars.x.push_back(low + (k + 0.5) * (high - low) / bins);
  for (double v : values) {
    const int k = (v - low) / (high - low) * bins;
    if (k >= 0 && k < bins) ++bars.y[k];
  }
  return bars;
}

}  // namespace

Table particle_table(const Shapes& shapes, const Particles& particles, const std::vector<double>& wanted) {
  Table t;
  t.columns = {"particle",   "class",       "size mm",         "volume_wanted mm³",
               "volume mm³", "surface mm²", "mean_caliper mm", "sphericity"};
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const Shape& s = shapes.shapes[particles.shape[i]];
    const double k = particles.scale[i];
    auto& row = t.rows.emplace_back();
    for (const double v :
         {static_cast<double>(i), static_cast<double>(particles.cls[i]), particles.size[i], wanted[i],
          s.volume * k * k * k, s.surface_area * k * k, s.mean_caliper * k, sphericity(s)})
      row.emplace_back(v);
  }
  return t;
}

Image fill_figure(const SizeDistribution& distribution, const FillResult& r) {
  const Table sizes = packing::size_table(distribution, r.expected, r.size_class, r.particles.box);
  const Plot by_size = packing::plot_of_sizes(sizes, "distribution", "after corrections");
  std::vector<double> round, error;
  for (std::size_t i = 0; i < r.wanted.size(); ++i) {
    round.push_back(sphericity(r.shapes.shapes[i]));
    error.push_back(100 * (r.shapes.shapes[i].volume / r.wanted[i] - 1));
  }
  Plot spheres;
  spheres.title = "Sphericity";
  spheres.x_label = "sphericity";
  spheres.y_label = "particles";
  spheres.series = {histogram(round, 0.4, 1, 30)};
  Plot errors;
  errors.title = "Error of volumes";
  errors.x_label = "percent";
  errors.y_label = "particles";
  errors.series = {histogram(error, -20, 20, 40)};
  return draw({by_size, spheres, errors}, 3);
}

}  // namespace terrazzo::tessellation
