#include "nodes/common/plot/drawing.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "nodes/common/plot/plot.h"
#include "nodes/common/plot/stroke_font.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo {

void Coverage::grow(int x0, int y0, int x1, int y1) {
  if (!mask_.empty()) {
    x0 = std::min(x0, x0_);
    y0 = std::min(y0, y0_);
    x1 = std::max(x1, x1_);
    y1 = std::max(y1, y1_);
  }
  if (!mask_.empty() && x0 == x0_ && y0 == y0_ && x1 == x1_ && y1 == y1_) return;
  std::vector<float> larger(static_cast<std::size_t>(x1 - x0) * (y1 - y0), 0.0f);
  for (int y = y0_; y < y1_; ++y)
    for (int x = x0_; x < x1_; ++x)
      larger[static_cast<std::size_t>(y - y0) * (x1 - x0) + (x - x0)] = at(x, y);
  mask_ = std::move(larger);
  x0_ = x0;
  y0_ = y0;
  x1_ = x1;
  y1_ = y1;
}

namespace {

double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * d).norm();
}

// First pixel of [lo, hi] and the one after its last, within [0, n].
std::pair<int, int> pixels_of(double lo, double hi, int n) {
  const double limit = n;
  return {round_down(std::clamp(lo, 0.0, limit)), round_up(std::clamp(hi, 0.0, limit))};
}

}  // namespace

void Coverage::stroke(const std::vector<Vec2>& points, double pen_width) {
  const double reach = pen_width / 2 + 1;
  Vec2 lo = Vec2::Constant(1e300), hi = -lo;
  for (const Vec2& p : points)
    if (p.allFinite()) {
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
  const auto [all_x0, all_x1] = pixels_of(lo.x() - reach, hi.x() + reach, width_);
  const auto [all_y0, all_y1] = pixels_of(lo.y() - reach, hi.y() + reach, height_);
  if (lo.x() > hi.x() || all_x0 >= all_x1 || all_y0 >= all_y1) return;
  grow(all_x0, all_y0, all_x1, all_y1);
  for (std::size_t i = 0; i < std::max<std::size_t>(points.size(), 2) - 1 && !points.empty(); ++i) {
    const Vec2 &a = points[i], &b = points[std::min(i + 1, points.size() - 1)];
    if (!a.allFinite() || !b.allFinite()) continue;
    const auto [x0, x1] = pixels_of(std::min(a.x(), b.x()) - reach, std::max(a.x(), b.x()) + reach, width_);
    const auto [y0, y1] = pixels_of(std::min(a.y(), b.y()) - reach, std::max(a.y(), b.y()) + reach, height_);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const double d = distance_to_segment({x + 0.5, y + 0.5}, a, b);
        // A pen thinner than a pixel covers only part of it.
        const double c = std::clamp(pen_width / 2 + 0.5 - d, 0.0, std::min(1.0, pen_width));
        at(x, y) = std::max<float>(at(x, y), c);
      }
  }
}

void Coverage::rectangle(double ax, double ay, double bx, double by) {
  if (!(ax < bx) || !(ay < by)) return;
  const auto [x0, x1] = pixels_of(ax, bx, width_);
  const auto [y0, y1] = pixels_of(ay, by, height_);
  if (x0 >= x1 || y0 >= y1) return;
  grow(x0, y0, x1, y1);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const double c = std::max(0.0, std::min(bx, x + 1.0) - std::max(ax, double(x))) *
                       std::max(0.0, std::min(by, y + 1.0) - std::max(ay, double(y)));
      at(x, y) = std::max<float>(at(x, y), c);
    }
}

void Coverage::paint(Image& image, const Vec3f& linear_color, double opacity) {
  const Vec3f ink = linear_to_srgb(linear_color);
  for (int y = y0_; y < std::min(y1_, image.height); ++y)
    for (int x = x0_; x < std::min(x1_, image.width); ++x) {
      const float c = at(x, y) * static_cast<float>(opacity);
      if (c <= 0) continue;
      Vec3f& pixel = image.at(x, y);
      if (c >= 1)
        pixel = linear_color;
      else
        pixel = srgb_to_linear(linear_to_srgb(pixel.cwiseMax(0.0f).cwiseMin(1.0f)) * (1 - c) + ink * c);
    }
  mask_.clear();
  x0_ = y0_ = x1_ = y1_ = 0;
}

namespace {

struct Placed {
  char32_t code;
  double size, drop;  // relative to the font size; units below the baseline
};

// Draws the index of standalone symbols such as N_A as a subscript; parameter_names remain unchanged.
std::vector<Placed> placed(const std::string& text) {
  const auto code = code_points(text);
  auto letter = [&](std::size_t i) {
    return i < code.size() && code[i] < 128 && (std::isalnum(static_cast<int>(code[i])) || code[i] == U'_');
  };
  std::vector<Placed> out;
  for (std::size_t i = 0; i < code.size(); ++i) {
    const bool symbol = letter(i) && code[i] != U'_' && !(i > 0 && letter(i - 1)) && i + 2 < code.size() &&
                        code[i + 1] == U'_' && letter(i + 2) && !letter(i + 3);
    out.push_back({code[i], 1, 0});
    if (symbol) out.push_back({code[i += 2], 0.7, 2.2});
  }
  return out;
}

}  // namespace

double text_extent(const std::string& text, double height) {
  double width = 0;
  for (const Placed& p : placed(text)) width += glyph(p.code).advance * p.size;
  return width * height / (kFontAscent + kFontDescent);
}

double add_text(Coverage& mask, double x, double y, const std::string& text, double height, Turn turn,
                double weight) {
  const double unit = height / (kFontAscent + kFontDescent);
  const double pen = std::max(1.0, kFontStroke * weight * unit);
  // Align the baseline, x-height and cap height to the pixel grid (with half of the pen's width), which keeps
  // small text crisp.
  const double half = 0.5 * (pen < 1.6 ? 1 : pen);
  auto level = [&](double h) { return h * unit < 1 ? h * unit : std::round(h * unit - half) + half; };
  const double low = half, x_height = std::max(level(7), low + 3), caps = std::max(level(10), x_height + 1);
  auto up = [&](double h) {
    if (h <= 0) return low + h * unit;
    if (h <= 7) return low + (x_height - low) * h / 7;
    return x_height + (caps - x_height) * (h - 7) / 3;
  };
  const double baseline = std::round(kFontAscent * unit);
  double at = pen / 2;
  for (const Placed& letter : placed(text)) {
    const Glyph& g = glyph(letter.code);
    for (const auto& s : g.strokes) {
      std::vector<Vec2> points;
      for (const Vec2& p : s) {
        const double along = at + p.x() * letter.size * unit;
        const double down =
            baseline - (letter.drop > 0 ? low + (p.y() * letter.size - letter.drop) * unit : up(p.y()));
        points.push_back(turn == Turn::None ? Vec2(x + along, y + down) : Vec2(x + down, y - along));
      }
      mask.stroke(points, pen);
    }
    at += g.advance * letter.size * unit;
  }
  return text_extent(text, height);
}

int draw_text(Image& image, int x, int y, const std::string& text, int height, const Vec3f& linear_color) {
  Coverage mask(image.width, image.height);
  const double width = add_text(mask, x, y, text, height);
  mask.paint(image, linear_color);
  return round_up(width);
}

int text_width(const std::string& text, int height) { return round_up(text_extent(text, height)); }

}  // namespace terrazzo
