#include "nodes/synthetic_photo/objects.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/plot/drawing.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/noise.h"

namespace terrazzo::synthetic_photo {
namespace {

Vec3f paint_color(Random& r) {
  static const float table[8][3] = {{.92f, .92f, .9f}, {.95f, .8f, .15f}, {.05f, .05f, .06f},
                                    {.6f, .6f, .62f},  {.75f, .6f, .4f},  {.8f, .15f, .1f},
                                    {.15f, .3f, .7f},  {.3f, .2f, .12f}};
  const auto& t = table[r.below(8)];
  return srgb_to_linear(Vec3f(t[0], t[1], t[2]));
}

// A turned rectangle on the canvas.
struct Board {
  double x, y, half_length, half_width, cosine, sine;
  bool inside(double px, double py, double& along, double& across) const {
    along = cosine * (px - x) + sine * (py - y), across = cosine * (py - y) - sine * (px - x);
    return std::abs(along) < half_length && std::abs(across) < half_width;
  }
};

template <class Shade>
void lay(Canvas& c, const Board& board, double thickness, Shade&& shade) {
  const double reach = std::hypot(board.half_length, board.half_width);
  float ground = -1e30f;
  double along = 0, across = 0;
  const int x0 = std::max(0, static_cast<int>(board.x - reach)),
            x1 = std::min(c.width - 1, static_cast<int>(board.x + reach));
  const int y0 = std::max(0, static_cast<int>(board.y - reach)),
            y1 = std::min(c.height - 1, static_cast<int>(board.y + reach));
  std::vector<float> heights;
  for (int y = y0; y <= y1; y += 3)
    for (int x = x0; x <= x1; x += 3)
      if (board.inside(x, y, along, across)) heights.push_back(c.z[c.at(x, y)]);
  if (heights.empty()) return;
  ground = at_rank(heights, heights.size() * 9 / 10) + static_cast<float>(thickness);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      if (!board.inside(x, y, along, across)) continue;
      const std::size_t i = c.at(x, y);
      c.z[i] = std::max(c.z[i], ground), c.id[i] = 0, c.other[i] = 1, c.gloss[i] = 0.1f;
      c.color[i] = shade(along, across);
    }
}

void ruler(Canvas& c, Random& r) {
  Board b{
      r.uniform(0, c.width), r.uniform(0, c.height), r.uniform(0.3, 1.2) * c.width, r.uniform(10, 40), 1, 0};
  const double turn =
      r.uniform() < 0.5 ? 1.5708 * static_cast<double>(r.below(4)) + 0.05 * r.normal() : r.uniform(0, 6.2832);
  b.cosine = std::cos(turn), b.sine = std::sin(turn);
  const Vec3f back = paint_color(r);
  const Vec3f mark = back.sum() > 0.6f ? Vec3f::Constant(0.02f) : Vec3f::Constant(0.85f);
  const bool blocks = r.uniform() < 0.35;
  const double step = r.uniform(4, 18), line = std::max(1.0, step * r.uniform(0.1, 0.3)),
               block = r.uniform(15, 60);
  const double numbers = step * 10;
  lay(c, b, r.uniform(0, 10), [&](double along, double across) -> Vec3f {
    const double w = across / b.half_width;
    if (blocks) return (static_cast<int>(std::floor(along / block)) + (w > 0)) % 2 == 0 ? back : mark;
    const int tick = static_cast<int>(std::floor(along / step + 0.5));
    const double length = tick % 10 == 0 ? 1.1 : tick % 5 == 0 ? 0.75 : 0.5;
    if (std::abs(along - tick * step) < line / 2 && w < -1 + length) return mark;
    // Digits: short strokes in a box beside each long tick.
    const double d = along - numbers * std::floor(along / numbers + 0.5);
    if (w > 0.1 && w < 0.75 && d > 2 && d < 0.9 * b.half_width + 2) {
      const int cell = static_cast<int>(d / 2.5) + 7 * static_cast<int>((w - 0.1) / 0.13) +
                       31 * static_cast<int>(std::floor(along / numbers));
      if (mix64(static_cast<std::uint64_t>(cell) + 17) % 5 < 2) return mark;
    }
    return back;
  });
}

void frame(Canvas& c, Random& r) {
  const Vec3f color = paint_color(r);
  const double width = r.uniform(8, 45), inset = r.uniform(-0.5, 3) * width;
  const std::uint64_t seed = r.bits();
  const double turn = 0.06 * r.normal();
  const int sides = 1 + static_cast<int>(r.below(15));
  for (int side = 0; side < 4; ++side) {
    if ((sides >> side & 1) == 0) continue;
    const double a = 1.5708 * side + turn, reach = (side % 2 == 0 ? c.height : c.width) / 2.0 - inset;
    Board b{c.width / 2.0 - std::sin(a) * reach,
            c.height / 2.0 + std::cos(a) * reach,
            1.0 * std::max(c.width, c.height),
            width / 2,
            std::cos(a),
            std::sin(a)};
    lay(c, b, r.uniform(0, 25), [&](double along, double across) -> Vec3f {
      return color * static_cast<float>(1 + 0.25 * turbulence(seed, Vec3(along / 60, across / 4, 0), 2));
    });
  }
}

void chart(Canvas& c, Random& r) {
  const double cell = r.uniform(12, 36);
  const int columns = 2 + static_cast<int>(r.below(6)), rows = 1 + static_cast<int>(r.below(4));
  Board b{r.uniform(0, c.width), r.uniform(0, c.height), cell * columns / 2, cell * rows / 2, 1, 0};
  const double turn = 0.2 * r.normal();
  b.cosine = std::cos(turn), b.sine = std::sin(turn);
  std::vector<Vec3f> colors;
  for (int i = 0; i < columns * rows; ++i)
    colors.push_back(srgb_to_linear(Vec3f(static_cast<float>(r.uniform()), static_cast<float>(r.uniform()),
                                          static_cast<float>(r.uniform()))));
  lay(c, b, r.uniform(0, 8), [&](double along, double across) -> Vec3f {
    const double u = along + b.half_length, v = across + b.half_width;
    const int i = std::clamp(static_cast<int>(u / cell), 0, columns - 1),
              j = std::clamp(static_cast<int>(v / cell), 0, rows - 1);
    const bool edge = u - i * cell < 2 || v - j * cell < 2;
    return edge ? Vec3f::Constant(0.03f) : colors[j * columns + i];
  });
}

// A caption on a bar along the lower edge, or a scale bar with its length somewhere in a corner.
void caption(Canvas& c, Random& r) {
  const bool bar = r.uniform() < 0.5, dark = r.uniform() < 0.6;
  const double height = r.uniform(18, 44);
  const Vec3f ink = Vec3f::Constant(dark ? 0.95f : 0.02f);
  Image picture(c.width, c.height, 1, 1);
  picture.pixels = c.color;
  const double top = bar ? c.height - height : r.uniform() < 0.7 ? c.height - 2.5 * height : height;
  const double left = r.uniform(0.03, 0.6) * c.width;
  if (bar)
    for (int y = static_cast<int>(top); y < c.height; ++y)
      for (int x = 0; x < c.width; ++x) {
        const std::size_t i = c.at(x, y);
        c.other[i] = 1, c.id[i] = 0, c.z[i] = 0, picture.pixels[i] = Vec3f::Constant(dark ? 0.01f : 0.95f);
      }
  Coverage mask(c.width, c.height);
  const std::string text = std::to_string(1 + r.below(900)) + (r.uniform() < 0.5 ? " mm" : " um");
  const double size = 0.5 * height, written = add_text(mask, left, top + 0.1 * height, text, size);
  const double length = r.uniform(40, 0.4 * c.width), thick = r.uniform(3, 9);
  mask.rectangle(left, top + 0.75 * height, left + length, top + 0.75 * height + thick);
  mask.paint(picture, ink);
  if (!bar)
    for (int y = static_cast<int>(top); y < std::min<double>(c.height, top + 0.75 * height + thick); ++y)
      for (int x = static_cast<int>(left); x < std::min<double>(c.width, left + std::max(written, length));
           ++x) {
        const std::size_t i = c.at(x, y);
        const bool in_text = x < left + written && y < top + 0.1 * height + 1.2 * size,
                   in_bar = x < left + length && y >= top + 0.75 * height;
        if (in_text || in_bar) c.other[i] = 1, c.id[i] = 0;
      }
  c.color = picture.pixels;
}

}  // namespace

void add_objects(Canvas& c, bool micrograph, Random& r) {
  if (micrograph) {
    if (r.uniform() < 0.3) caption(c, r);
    return;
  }
  if (r.uniform() < 0.10) ruler(c, r);
  if (r.uniform() < 0.07) frame(c, r);
  if (r.uniform() < 0.04) chart(c, r);
  if (r.uniform() < 0.04) caption(c, r);
}

}  // namespace terrazzo::synthetic_photo
