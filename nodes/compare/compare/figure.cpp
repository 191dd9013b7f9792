#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/plot/drawing.h"
#include "nodes/common/plot/plot.h"
#include "nodes/compare/compare/comparison.h"

namespace terrazzo::compare {

namespace {

constexpr int kHeight = 480;
const Vec3f ink = Vec3f::Constant(0.02f);

void fill(Image& image, int x0, int y0, int x1, int y1, const Vec3f& color) {
  for (int y = std::max(y0, 0); y < std::min(y1, image.height); ++y)
    for (int x = std::max(x0, 0); x < std::min(x1, image.width); ++x)
      image.at(x, y) = color.cwiseMax(0.0f).cwiseMin(1.0f);
}

Plot bars_of(const Comparison& c, const std::string& name_a, const std::string& name_b) {
  Plot plot;
  PlotSeries a, b;
  a.kind = b.kind = PlotSeries::Kind::Bars;
  a.name = name_a + ", with the sampling noise of the difference";
  b.name = name_b;
  b.color = 1;
  for (const auto& n : c.numbers) {
    if (!(n.upper > n.lower)) continue;
    const double x = (n.lower + n.upper) / 2;
    a.x.push_back(x);
    b.x.push_back(x);
    a.y.push_back(n.a);
    b.y.push_back(n.b);
    a.low.push_back(std::max(0.0, n.a - n.tolerance));
    a.high.push_back(n.a + n.tolerance);
    plot.y_label = (n.item.starts_with("N_V") ? "N_V per class"
                    : n.unit.empty()          ? "share per class"
                                              : "N_A per class") +
                   (n.unit.empty() ? "" : ", " + n.unit);
    plot.x_label = n.item.starts_with("N_V") ? "particle size, mm" : "profile diameter √(4A/π), mm";
    plot.title = n.item.starts_with("N_V") ? "Particles per volume" : "Profiles per area";
  }
  plot.series = {a, b};
  return plot;
}

// A pair of bars for one number without bins.
Plot pair_of(const ComparedNumber& n, const std::string& title, const std::string& name_a,
             const std::string& name_b) {
  Plot plot;
  plot.title = title;
  plot.width = 300;
  plot.height = kHeight;
  plot.x_words = {name_a, name_b};
  for (int k = 0; k < 2; ++k) {
    PlotSeries s;
    s.kind = PlotSeries::Kind::Bars;
    s.color = k;
    s.x = {0, 1};
    s.y = {k == 0 ? n.a : NAN, k == 1 ? n.b : NAN};
    if (k == 0) {
      s.low = {n.a - n.tolerance, NAN};
      s.high = {n.a + n.tolerance, NAN};
    }
    plot.series.push_back(s);
  }
  return plot;
}

Image swatches_of(const Comparison& c, const std::string& name_a, const std::string& name_b) {
  Image image(300, kHeight, 1, 1, Vec3f::Ones());
  Coverage title(image.width, image.height);
  add_text(title, 16, 12, "Mean colors", 19, Turn::None, 1.25);  // matches the titles of the adjacent plots
  title.paint(image, ink);
  draw_text(image, 24, 48, name_a, 15, ink);
  draw_text(image, 150, 48, name_b, 15, ink);
  const int rows = c.colors.size(), step = std::min(200, (kHeight - 90) / std::max(rows, 1));
  for (int r = 0; r < rows; ++r) {
    const int top = 74 + r * step, bottom = top + step - 56;
    fill(image, 24, top, 150, bottom, c.colors[r].a);
    fill(image, 150, top, 276, bottom, c.colors[r].b);
    draw_text(image, 24, bottom + 8, fmt::format("{}: ΔE {:.3f}", c.colors[r].name, c.colors[r].delta), 15,
              ink);
  }
  return image;
}

}  // namespace

Table table_of(const Comparison& c) {
  Table t;
  t.columns = {"measure", "item", "unit",       "lower mm",  "upper mm",
               "a",       "b",    "difference", "tolerance", "exceeds"};
  for (const auto& n : c.numbers) {
    const bool bin = n.upper > n.lower;
    auto number_or_nothing = [](bool is, double v) {
      return is ? Table::Cell(v) : Table::Cell(std::string());
    };
    t.rows.push_back({n.measure, n.item, n.unit, number_or_nothing(bin, n.lower),
                      number_or_nothing(bin, n.upper), n.a, n.b, n.b - n.a,
                      number_or_nothing(std::isfinite(n.tolerance), n.tolerance), n.exceeds() ? 1.0 : 0.0});
  }
  return t;
}

Image figure_of(const Comparison& c, const std::string& name_a, const std::string& name_b) {
  std::vector<Image> panels;
  if (std::any_of(c.numbers.begin(), c.numbers.end(), [](const auto& n) { return n.upper > n.lower; }))
    panels.push_back(draw(bars_of(c, name_a, name_b)));
  for (const auto& n : c.numbers)
    if (n.measure == "area_fraction") panels.push_back(draw(pair_of(n, "Area fraction", name_a, name_b)));
  if (!c.colors.empty()) panels.push_back(swatches_of(c, name_a, name_b));
  for (Plot plot : c.plots) {
    const std::string names[] = {name_a, name_b};
    for (std::size_t k = 0; k < plot.series.size() && k < 2; ++k) plot.series[k].name = names[k];
    plot.width = 480;
    plot.height = kHeight;
    panels.push_back(draw(plot));
  }
  if (panels.empty()) panels.push_back(draw(Plot{}));
  int width = 0;
  for (const Image& p : panels) width += p.width;
  Image figure(width, kHeight, 1, 1, Vec3f::Ones());
  int left = 0;
  for (const Image& p : panels) {
    for (int y = 0; y < std::min(kHeight, p.height); ++y)
      for (int x = 0; x < p.width; ++x) figure.at(left + x, y) = p.at(x, y);
    left += p.width;
  }
  return figure;
}

}  // namespace terrazzo::compare
