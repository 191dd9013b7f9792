#include "nodes/photograph/synthetic_photo/objects.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "nodes/common/plot/drawing.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/noise.h"
#include "nodes/photograph/synthetic_photo/board.h"
#include "nodes/photograph/synthetic_photo/rulers.h"

namespace terrazzo::synthetic_photo {
namespace {

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
  b.cosine = std::cos(turn);
  b.sine = std::sin(turn);
  std::vector<Vec3f> colors;
  for (int i = 0; i < columns * rows; ++i)
    colors.push_back(srgb_to_linear(Vec3f(static_cast<float>(r.uniform()), static_cast<float>(r.uniform()),
                                          static_cast<float>(r.uniform()))));
  lay(c, b, r.uniform(0, 8), [&](double along, double across) -> Vec3f {
    const double u = along + b.half_length, v = across + b.half_width;
    const int i = std::clamp<int>(u / cell, 0, columns - 1), j = std::clamp<int>(v / cell, 0, rows - 1);
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
    for (int y = top; y < c.height; ++y)
      for (int x = 0; x < c.width; ++x) {
        const std::size_t i = c.at(x, y);
        c.other[i] = 1;
        c.id[i] = 0;
        c.z[i] = 0;
        picture.pixels[i] = Vec3f::Constant(dark ? 0.01f : 0.95f);
      }
  Coverage mask(c.width, c.height);
  const std::string text = std::to_string(1 + r.below(900)) + (r.uniform() < 0.5 ? " mm" : " um");
  const double size = 0.5 * height, written = add_text(mask, left, top + 0.1 * height, text, size);
  const double length = r.uniform(40, 0.4 * c.width), thick = r.uniform(3, 9);
  mask.rectangle(left, top + 0.75 * height, left + length, top + 0.75 * height + thick);
  mask.paint(picture, ink);
  if (!bar)
    for (int y = top; y < std::min<double>(c.height, top + 0.75 * height + thick); ++y)
      for (int x = left; x < std::min<double>(c.width, left + std::max(written, length)); ++x) {
        const std::size_t i = c.at(x, y);
        const bool in_text = x < left + written && y < top + 0.1 * height + 1.2 * size,
                   in_bar = x < left + length && y >= top + 0.75 * height;
        if (in_text || in_bar) {
          c.other[i] = 1;
          c.id[i] = 0;
        }
      }
  c.color = picture.pixels;
}

// A disc of metal with a rim and a worn relief.
void coin(Canvas& c, Random& r) {
  const double radius = r.uniform(14, 60);
  static const float metals[3][3] = {{.72f, .72f, .74f}, {.8f, .62f, .3f}, {.6f, .36f, .22f}};
  const auto& m = metals[r.below(3)];
  const Vec3f color = srgb_to_linear(Vec3f(m[0], m[1], m[2]));
  const std::uint64_t seed = r.bits();
  const Board b = Board::turned(r.uniform(0, c.width), r.uniform(0, c.height), radius, radius, 0);
  lay(c, b, r.uniform(1, 8), [&](double along, double across) -> std::optional<Vec3f> {
    const double far = std::hypot(along, across) / radius;
    if (far > 1) return {};
    const double relief = turbulence(seed, Vec3(along / (0.2 * radius), across / (0.2 * radius), 0), 3);
    return color * static_cast<float>(far > 0.88 ? 1.25 : 0.9 + 0.5 * relief);
  });
}

// A pen or pencil: round, with a tip and a part of another color.
void pen(Canvas& c, Random& r) {
  const double length = r.uniform(60, 220), width = r.uniform(4, 11), tip = r.uniform(2, 5) * width,
               cap = r.uniform(-1, 0.6) * length;
  const Vec3f body = paint_color(r), other = paint_color(r);
  const Board b =
      Board::turned(r.uniform(0, c.width), r.uniform(0, c.height), length, width, r.uniform(0, 6.2832));
  lay(c, b, r.uniform(2, 12), [&](double along, double across) -> std::optional<Vec3f> {
    const double thick = along > length - tip ? std::max(0.2, (length - along) / tip) : 1;
    const double w = across / (width * thick);
    if (std::abs(w) > 1) return {};
    return (along < cap ? other : body) * static_cast<float>(0.35 + 0.8 * std::sqrt(1 - w * w));
  });
}

}  // namespace

void add_objects(Canvas& c, bool micrograph, Random& r) {
  if (micrograph) {
    if (r.uniform() < 0.3) caption(c, r);
    return;
  }
  if (r.uniform() < 0.10) add_ruler(c, r);
  if (r.uniform() < 0.07) frame(c, r);
  if (r.uniform() < 0.04) chart(c, r);
  if (r.uniform() < 0.04) caption(c, r);
  if (r.uniform() < 0.05) add_folding_ruler(c, r);
  if (r.uniform() < 0.04) add_tape(c, r);
  if (r.uniform() < 0.05) add_scale_card(c, r);
  if (r.uniform() < 0.04) coin(c, r);
  if (r.uniform() < 0.04) pen(c, r);
}

}  // namespace terrazzo::synthetic_photo
