#include "nodes/common/plot/plot.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/plot/drawing.h"
#include "nodes/common/plot/plot_axis.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo {

namespace {

// Okabe and Ito (2008), distinguishable with all common types of color vision; sRGB.
constexpr std::array<std::array<int, 3>, 8> kPalette = {{{0, 114, 178},
                                                         {213, 94, 0},
                                                         {0, 158, 115},
                                                         {204, 121, 167},
                                                         {230, 159, 0},
                                                         {86, 180, 233},
                                                         {70, 70, 70},
                                                         {120, 94, 240}}};

Vec3f from_srgb(int r, int g, int b) { return srgb_to_linear(Vec3f(r / 255.0f, g / 255.0f, b / 255.0f)); }
Vec3f color_of(int index) {
  const auto& c = kPalette[((index % 8) + 8) % 8];
  return from_srgb(c[0], c[1], c[2]);
}
const Vec3f& text_color() {
  static const Vec3f c = from_srgb(38, 38, 42);
  return c;
}

constexpr double kSmall = 15, kNormal = 16, kLarge = 19;  // line heights, pixels

// The plot area, and its mapping from data to pixels.
struct Frame {
  double left, top, right, bottom;
  PlotAxis x, y;
  double px(double v) const { return left + x.place(v) * (right - left); }
  double py(double v) const { return bottom - y.place(v) * (bottom - top); }
};

std::size_t points_of(const PlotSeries& s) { return std::min(s.x.size(), s.y.size()); }

// The smallest distance of two bars in units of x, logarithmic if log_x.
double bar_spacing(const Plot& plot) {
  double spacing = INFINITY;
  for (const auto& s : plot.series) {
    if (s.kind != PlotSeries::Kind::Bars) continue;
    std::vector<double> x(s.x.begin(), s.x.begin() + points_of(s));
    std::erase_if(x, [&](double v) { return !std::isfinite(v) || (plot.log_x && v <= 0); });
    if (plot.log_x)
      for (double& v : x) v = std::log(v);
    std::sort(x.begin(), x.end());
    for (std::size_t i = 1; i < x.size(); ++i)
      if (x[i] > x[i - 1]) spacing = std::min(spacing, x[i] - x[i - 1]);
  }
  return std::isfinite(spacing) ? spacing : 1;
}

// Whether two series have a bar at the same x, so that bars must be drawn side by side.
bool bars_share_places(const Plot& plot) {
  std::vector<double> taken;
  for (const auto& s : plot.series) {
    if (s.kind != PlotSeries::Kind::Bars) continue;
    const std::size_t others = taken.size();
    for (std::size_t i = 0; i < points_of(s); ++i) {
      if (!std::isfinite(s.y[i])) continue;
      if (std::find(taken.begin(), taken.begin() + others, s.x[i]) != taken.begin() + others) return true;
      taken.push_back(s.x[i]);
    }
  }
  return false;
}

void collect(const Plot& plot, std::vector<double>& xs, std::vector<double>& ys, bool& bars) {
  const double half = bar_spacing(plot) / 2;
  if (!plot.x_words.empty()) xs = {-0.5, plot.x_words.size() - 0.5};
  for (const auto& s : plot.series) {
    const bool is_bars = s.kind == PlotSeries::Kind::Bars;
    bars = bars || is_bars;
    for (std::size_t i = 0; i < points_of(s); ++i) {
      if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i])) continue;
      if (is_bars && plot.log_x) {
        xs.push_back(s.x[i] * std::exp(-half));
        xs.push_back(s.x[i] * std::exp(half));
      } else if (is_bars) {
        xs.push_back(s.x[i] - half);
        xs.push_back(s.x[i] + half);
      } else {
        xs.push_back(s.x[i]);
      }
      ys.push_back(s.y[i]);
      if (i < s.low.size()) ys.push_back(s.low[i]);
      if (i < s.high.size()) ys.push_back(s.high[i]);
    }
  }
}

void write(Image& image, double x, double y, const std::string& words, double height, const Vec3f& color,
           double weight = 1) {
  Coverage mask(image.width, image.height);
  add_text(mask, x, y, words, height, Turn::None, weight);
  mask.paint(image, color);
}

// Swatch and name of every named series, in as many rows as needed. Returns the height; draws only if `image`
// is given.
double legend(Image* image, const Plot& plot, double left, double right, double top) {
  const double swatch = 18, gap = 7, between = 22, row = 21;
  double x = left, y = top;
  bool any = false;
  for (const auto& s : plot.series) {
    if (s.name.empty()) continue;
    const double width = swatch + gap + text_extent(s.name, kSmall);
    if (x > left && x + width > right) {
      x = left;
      y += row;
    }
    if (image) {
      Coverage mask(image->width, image->height);
      const double middle = y + 10;
      if (s.kind == PlotSeries::Kind::Bars) {
        mask.rectangle(x + 2, middle - 6, x + swatch - 2, middle + 6);
      } else if (s.kind == PlotSeries::Kind::Line) {
        mask.stroke({{x + 1, middle}, {x + swatch - 1, middle}}, 2.2);
      } else {
        mask.disc({x + swatch / 2, middle}, 4);
      }
      mask.paint(*image, color_of(s.color));
      write(*image, x + swatch + gap, y + 3, s.name, kSmall, text_color());
    }
    x += width + between;
    any = true;
  }
  return any ? y - top + row : 0;
}

void draw_axes(Image& image, const Plot& plot, const Frame& f) {
  const Vec3f grid = from_srgb(230, 231, 234), line = from_srgb(110, 112, 118);
  Coverage mask(image.width, image.height);
  auto crisp = [](double v) { return std::floor(v); };
  for (double t : f.y.ticks) mask.rectangle(f.left, crisp(f.py(t)), f.right, crisp(f.py(t)) + 1);
  mask.paint(image, grid);
  mask.rectangle(f.left, crisp(f.bottom), f.right, crisp(f.bottom) + 1);
  for (double t : f.x.ticks) mask.rectangle(crisp(f.px(t)), f.bottom, crisp(f.px(t)) + 1, f.bottom + 6);
  for (double t : f.x.minor) mask.rectangle(crisp(f.px(t)), f.bottom, crisp(f.px(t)) + 1, f.bottom + 3);
  for (double t : f.y.minor) mask.rectangle(f.left - 3, crisp(f.py(t)), f.left, crisp(f.py(t)) + 1);
  mask.paint(image, line);
  for (std::size_t i = 0; i < f.x.ticks.size(); ++i) {
    const double width = text_extent(f.x.words[i], kSmall);
    write(image, std::round(f.px(f.x.ticks[i]) + 0.5 - width / 2), f.bottom + 8, f.x.words[i], kSmall,
          text_color());
  }
  for (std::size_t i = 0; i < f.y.ticks.size(); ++i) {
    const double width = text_extent(f.y.words[i], kSmall);
    write(image, std::round(f.left - 7 - width), std::round(f.py(f.y.ticks[i]) - kSmall / 2), f.y.words[i],
          kSmall, text_color());
  }
  if (!plot.x_label.empty())
    write(image, std::round((f.left + f.right - text_extent(plot.x_label, kNormal)) / 2), f.bottom + 27,
          plot.x_label, kNormal, text_color());
  if (!plot.y_label.empty()) {
    const double middle = (f.top + f.bottom) / 2 + text_extent(plot.y_label, kNormal) / 2;
    add_text(mask, 8, std::round(std::min(middle, image.height - 6.0)), plot.y_label, kNormal, Turn::Left);
    mask.paint(image, text_color());
  }
}

// Draws the marks of a series, clipped to the frame, and its intervals as whiskers.
void draw_series(Image& image, const Plot& plot, const Frame& f, const PlotSeries& s, int bar, int bars) {
  Coverage mask(image.width, image.height), whiskers(image.width, image.height);
  const Vec3f color = color_of(s.color);
  double group = bar_spacing(plot);  // in pixels from here on
  group = plot.log_x ? group / std::log(f.x.hi / f.x.lo) : group / (f.x.hi - f.x.lo);
  group *= f.right - f.left;
  const double share = group * 0.8 / std::max(1, bars), width = share > 4 ? std::min(share - 1, 60.0) : share;
  std::vector<Vec2> line;
  auto flush = [&] {
    mask.stroke(line, 2.2);
    line.clear();
  };
  auto inside = [](double v, double lo, double hi) { return v >= lo - 0.5 && v <= hi + 0.5; };
  for (std::size_t i = 0; i < points_of(s); ++i) {
    if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i])) {
      flush();
      continue;
    }
    double x = f.px(s.x[i]);
    const double y = std::clamp(f.py(s.y[i]), -1e5, 1e5);
    if (s.kind == PlotSeries::Kind::Bars) {
      x += share * (bar - (bars - 1) / 2.0);
      const double zero = std::clamp(f.y.log ? f.bottom : f.py(0), f.top, f.bottom),
                   end = std::clamp(y, f.top, f.bottom);
      mask.rectangle(x - width / 2, std::min(zero, end), x + width / 2, std::max(zero, end));
    } else if (s.kind == PlotSeries::Kind::Line) {
      line.emplace_back(x, std::clamp(y, f.top - 2, f.bottom + 2));
    } else if (inside(x, f.left, f.right) && inside(y, f.top, f.bottom)) {
      mask.disc({x, y}, 3.6);
    }
    const double low = i < s.low.size() ? s.low[i] : NAN, high = i < s.high.size() ? s.high[i] : NAN;
    if (std::isfinite(low) && std::isfinite(high) && high > low && inside(x, f.left, f.right)) {
      const double from = std::clamp(f.py(low), f.top, f.bottom),
                   to = std::clamp(f.py(high), f.top, f.bottom);
      const double cap = s.kind == PlotSeries::Kind::Bars ? std::clamp(width / 4, 1.5, 6.0) : 4;
      whiskers.stroke({{x, from}, {x, to}}, 1.4);
      whiskers.stroke({{x - cap, from}, {x + cap, from}}, 1.4);
      whiskers.stroke({{x - cap, to}, {x + cap, to}}, 1.4);
    }
  }
  flush();
  mask.paint(image, color);
  whiskers.paint(image, s.kind == PlotSeries::Kind::Bars ? Vec3f(text_color()) : color);
}

}  // namespace

Image draw(const Plot& plot) {
  Image image(std::max(plot.width, 160), std::max(plot.height, 120), 1, 1, Vec3f::Ones());
  std::vector<double> xs, ys;
  bool has_bars = false;
  collect(plot, xs, ys, has_bars);

  double top = 12;
  if (!plot.title.empty()) {
    write(image, 16, top, plot.title, kLarge, text_color(), 1.25);
    top += 27;
  }
  top += legend(&image, plot, 16, image.width - 16, top) + 10;

  Frame f;
  f.top = top;
  f.bottom = image.height - (plot.x_label.empty() ? 30 : 54);
  f.right = image.width - 20;
  f.bottom = std::max(f.bottom, f.top + 20);
  const int rows = std::clamp<int>((f.bottom - f.top) / 45, 2, 8);
  f.y = make_axis(ys, plot.log_y, has_bars && !plot.log_y, false, rows);
  double widest = 0;
  for (const auto& w : f.y.words) widest = std::max(widest, text_extent(w, kSmall));
  f.left = std::min((plot.y_label.empty() ? 14 : 34) + std::ceil(widest) + 7, image.width / 2.0);
  f.x = make_axis(xs, plot.log_x, false, has_bars, std::clamp<int>((f.right - f.left) / 80, 2, 10));
  if (!plot.x_words.empty()) {
    f.x.ticks.clear();
    f.x.minor.clear();
    f.x.words = plot.x_words;
    for (std::size_t i = 0; i < plot.x_words.size(); ++i) f.x.ticks.push_back(static_cast<double>(i));
  }
  // Leave room for the last tick label.
  if (!f.x.words.empty())
    f.right = std::min(f.right, image.width - 8 - text_extent(f.x.words.back(), kSmall) / 2 +
                                    (1 - f.x.place(f.x.ticks.back())) * (f.right - f.left));

  draw_axes(image, plot, f);
  int bars = 0, bar = 0;
  for (const auto& s : plot.series) bars += s.kind == PlotSeries::Kind::Bars;
  const bool grouped = bars_share_places(plot);
  for (const auto& s : plot.series)
    if (s.kind == PlotSeries::Kind::Bars)
      draw_series(image, plot, f, s, grouped ? bar++ : 0, grouped ? bars : 1);
  for (const auto& s : plot.series)
    if (s.kind != PlotSeries::Kind::Bars) draw_series(image, plot, f, s, 0, bars);
  if (ys.empty()) {
    const std::string words = "no data";
    write(image, (f.left + f.right - text_extent(words, kNormal)) / 2, (f.top + f.bottom) / 2 - kNormal / 2,
          words, kNormal, from_srgb(140, 140, 146));
  }
  return image;
}

Image draw(const std::vector<Plot>& plots, int columns) {
  if (plots.empty()) return draw(Plot{});
  columns = std::clamp(columns, 1, count_of(plots));
  std::vector<Image> images;
  for (const auto& p : plots) images.push_back(draw(p));
  const int rows = (count_of(images) + columns - 1) / columns;
  std::vector<int> x(columns + 1, 0),
      y(rows + 1, 0);  // each column as wide as its widest plot, each row as high as its highest
  for (std::size_t i = 0; i < images.size(); ++i) {
    int &w = x[i % columns + 1], &h = y[i / columns + 1];
    w = std::max(w, images[i].width);
    h = std::max(h, images[i].height);
  }
  for (int c = 0; c < columns; ++c) x[c + 1] += x[c];
  for (int r = 0; r < rows; ++r) y[r + 1] += y[r];
  Image sheet(x[columns], y[rows], 1, 1, Vec3f::Ones());
  for (std::size_t i = 0; i < images.size(); ++i)
    for (int v = 0; v < images[i].height; ++v)
      for (int u = 0; u < images[i].width; ++u)
        sheet.at(x[i % columns] + u, y[i / columns] + v) = images[i].at(u, v);
  return sheet;
}

}  // namespace terrazzo
