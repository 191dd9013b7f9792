#include "nodes/properties/homogenize/report.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/plot/plot.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::homogenize {
namespace {

constexpr int kSlice = 400;       // pixels of the longer edge of the slice
constexpr int kTop = 46;          // above it
constexpr double kBright = 0.99;  // share of the voxels below the brightest color

// From black through red and yellow to white: brightness grows with the value.
Vec3f heat(double t) {
  const auto ramp = [&](double from) { return static_cast<float>(std::clamp(3 * t - from, 0.0, 1.0)); };
  return {ramp(0), ramp(1), ramp(2)};
}

// The value below which a share of the field lies.
double quantile(std::vector<float> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * (values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Image slice_of(const std::vector<float>& field, const VoxelBox& box) {
  const Vec3i& n = box.size;
  const Vec3 edge = n.cast<double>().cwiseProduct(box.spacing);
  const double scale = kSlice / std::max(edge.x(), edge.y());
  Image out(std::max(1, round_nearest(scale * edge.x())), std::max(1, round_nearest(scale * edge.y())), 1, 1);
  const double most = quantile(field, kBright);
  for (int j = 0; j < out.height; ++j)
    for (int i = 0; i < out.width; ++i) {
      const int x = std::min(n.x() - 1, static_cast<int>((i + 0.5) * n.x() / out.width));
      const int y = n.y() - 1 - std::min(n.y() - 1, static_cast<int>((j + 0.5) * n.y() / out.height));
      const float v = field[voxel_at(x, y, n.z() / 2, n)];
      out.at(i, j) = srgb_to_linear(heat(most > 0 ? std::min(1.0, v / most) : 0));
    }
  return out;
}

Plot plot_of(const Shown& shown) {
  Plot plot;
  plot.title = shown.title;
  plot.y_label = shown.value_label;
  plot.x_words = shown.names;
  plot.width = 560;
  PlotSeries bars;
  bars.kind = PlotSeries::Kind::Bars;
  const double last = count_of(shown.values) - 1;
  for (std::size_t k = 0; k < shown.values.size(); ++k) {
    bars.x.push_back(k);
    bars.y.push_back(shown.values[k]);
  }
  plot.series.push_back(bars);
  if (!shown.bounds) return plot;
  for (const auto& [name, value, color] : {std::tuple("lower " + shown.bounds_name, shown.bounds->low, 1),
                                           std::tuple("upper " + shown.bounds_name, shown.bounds->high, 2)}) {
    PlotSeries line;
    line.name = name;
    line.color = color;
    line.x = {-0.5, last + 0.5};
    line.y = {value, value};
    plot.series.push_back(line);
  }
  return plot;
}

}  // namespace

void add_coarse_values(std::vector<Measure>& measures, const std::vector<Measure>& coarse) {
  for (Measure& m : measures)
    for (const Measure& other : coarse)
      if (other.name == m.name) m.coarse = other.value;
}

Table table_of(const std::vector<Measure>& measures) {
  Table out;
  out.columns = {"measure", "value", "unit", "half_resolution"};
  for (const Measure& m : measures) {
    out.rows.push_back({m.name, m.value, m.unit, std::string()});
    if (m.coarse) out.rows.back().back() = *m.coarse;
  }
  return out;
}

Table tensor_table(const Eigen::MatrixXd& m, const std::vector<std::string>& axes) {
  Table out;
  out.columns = axes;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    out.rows.emplace_back();
    for (Eigen::Index j = 0; j < m.cols(); ++j) out.rows.back().emplace_back(m(i, j));
  }
  return out;
}

Image figure_of(const Shown& shown, const VoxelBox& box) {
  const Image plot = draw(plot_of(shown));
  if (!shown.field || shown.field->empty()) return plot;
  const Image slice = slice_of(*shown.field, box);
  Image out(plot.width + slice.width + kTop, std::max(plot.height, slice.height + 2 * kTop), 1, 1,
            Vec3f::Constant(1));
  for (int y = 0; y < plot.height; ++y)
    for (int x = 0; x < plot.width; ++x) out.at(x, y) = plot.at(x, y);
  for (int y = 0; y < slice.height; ++y)
    for (int x = 0; x < slice.width; ++x) out.at(plot.width + x, kTop + y) = slice.at(x, y);
  draw_text(out, plot.width, kTop / 2, shown.field_name, 14, Vec3f::Zero());
  return out;
}

}  // namespace terrazzo::homogenize
