#include "nodes/photograph/synthetic_photo/rulers.h"

#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/synthetic_photo/board.h"

namespace terrazzo::synthetic_photo {
namespace {

Vec3f ink_on(const Vec3f& paper) {
  return paper.sum() > 0.6f ? Vec3f::Constant(0.02f) : Vec3f::Constant(0.85f);
}

// Digits or letters: short strokes in cells of `cell` pixels, which look like writing from afar.
bool writing(double along, double across, double cell, std::uint64_t seed) {
  const auto at = static_cast<std::int64_t>(std::floor(along / cell)) * 31 +
                  static_cast<std::int64_t>(std::floor(across / cell)) * 7;
  return mix64(at + seed) % 5 < 2;
}

// Millimeters on one side of a strip, or on both, with numbers between them. `w`: from −1 to 1 across.
struct Scale {
  double step, line, half_width;
  bool both;
  std::uint64_t seed;

  bool marked(double along, double w) const {
    const std::int64_t tick = std::floor(along / step + 0.5);
    const double length = tick % 10 == 0 ? 0.8 : tick % 5 == 0 ? 0.6 : 0.4;
    const bool on_tick = std::abs(along - tick * step) < line / 2;
    if (on_tick && (w < -1 + length || (both && w > 1 - length))) return true;
    const double numbers = 10 * step, d = along - numbers * std::floor(along / numbers + 0.5);
    return std::abs(w - (both ? 0 : 0.4)) < 0.25 && d > 2 && d < 0.7 * half_width + 2 &&
           writing(along, w * half_width, std::max(1.5, half_width / 9), seed);
  }
};

Scale random_scale(double half_width, Random& r) {
  const double step = r.uniform(4, 18);
  return {step, std::max(1.0, step * r.uniform(0.1, 0.3)), half_width, r.uniform() < 0.5, r.bits()};
}

Vec3f strip_color(Random& r) {
  static const float table[4][3] = {
      {.94f, .93f, .88f}, {.95f, .8f, .15f}, {.85f, .7f, .45f}, {.9f, .9f, .92f}};
  const auto& t = table[r.below(4)];
  return srgb_to_linear(Vec3f(t[0], t[1], t[2]));
}

}  // namespace

Vec3f paint_color(Random& r) {
  static const float table[8][3] = {{.92f, .92f, .9f}, {.95f, .8f, .15f}, {.05f, .05f, .06f},
                                    {.6f, .6f, .62f},  {.75f, .6f, .4f},  {.8f, .15f, .1f},
                                    {.15f, .3f, .7f},  {.3f, .2f, .12f}};
  const auto& t = table[r.below(8)];
  return srgb_to_linear(Vec3f(t[0], t[1], t[2]));
}

double angle_of_thing(Random& r) {
  return r.uniform() < 0.5 ? 1.5708 * r.below(4) + 0.05 * r.normal() : r.uniform(0, 6.2832);
}

void add_ruler(Canvas& c, Random& r) {
  Board b{
      r.uniform(0, c.width), r.uniform(0, c.height), r.uniform(0.3, 1.2) * c.width, r.uniform(10, 40), 1, 0};
  const double turn = r.uniform() < 0.5 ? 1.5708 * r.below(4) + 0.05 * r.normal() : r.uniform(0, 6.2832);
  b.cosine = std::cos(turn);
  b.sine = std::sin(turn);
  const Vec3f back = paint_color(r);
  const Vec3f mark = back.sum() > 0.6f ? Vec3f::Constant(0.02f) : Vec3f::Constant(0.85f);
  const bool blocks = r.uniform() < 0.35;
  const double step = r.uniform(4, 18), line = std::max(1.0, step * r.uniform(0.1, 0.3)),
               block = r.uniform(15, 60);
  const double numbers = step * 10;
  lay(c, b, r.uniform(0, 10), [&](double along, double across) -> Vec3f {
    const double w = across / b.half_width;
    if (blocks) return (round_down(along / block) + (w > 0)) % 2 == 0 ? back : mark;
    const int tick = round_down(along / step + 0.5);
    const double length = tick % 10 == 0 ? 1.1 : tick % 5 == 0 ? 0.75 : 0.5;
    if (std::abs(along - tick * step) < line / 2 && w < -1 + length) return mark;
    // Digits: short strokes in a box beside each long tick.
    const double d = along - numbers * std::floor(along / numbers + 0.5);
    if (w > 0.1 && w < 0.75 && d > 2 && d < 0.9 * b.half_width + 2) {
      const int cell = static_cast<int>(d / 2.5) + 7 * static_cast<int>((w - 0.1) / 0.13) +
                       31 * round_down(along / numbers);
      if (mix64(static_cast<std::uint64_t>(cell) + 17) % 5 < 2) return mark;
    }
    return back;
  });
}

void add_folding_ruler(Canvas& c, Random& r) {
  const double half_width = r.uniform(9, 26), half_length = r.uniform(0.15, 0.5) * c.width;
  const Vec3f paper = strip_color(r), ink = ink_on(paper),
              metal = Vec3f::Constant(static_cast<float>(r.uniform(0.2, 0.5)));
  Scale scale = random_scale(half_width, r);
  scale.both = r.uniform() < 0.8;
  double x = r.uniform(0, c.width), y = r.uniform(0, c.height), angle = angle_of_thing(r);
  const double height = r.uniform(1, 10);
  const int limbs = 1 + static_cast<int>(r.below(4));
  for (int k = 0; k < limbs; ++k) {
    const Board limb = Board::turned(x + half_length * std::cos(angle), y + half_length * std::sin(angle),
                                     half_length, half_width, angle);
    lay(c, limb, height + 2 * k, [&](double along, double across) -> std::optional<Vec3f> {
      return scale.marked(along, across / half_width) ? ink : paper;
    });
    x += 2 * half_length * std::cos(angle);
    y += 2 * half_length * std::sin(angle);
    const double radius = r.uniform(0.5, 0.9) * half_width;
    const Board hinge = Board::turned(x, y, radius, radius, 0);
    lay(c, hinge, height + 2 * k + 2, [&](double along, double across) -> std::optional<Vec3f> {
      const double far = std::hypot(along, across) / radius;
      if (far > 1) return {};
      return metal * static_cast<float>(far < 0.35 ? 0.5 : 1.2 - 0.4 * far);
    });
    angle += r.uniform() < 0.3 ? 0.1 * r.normal() : r.uniform(0.4, 2.6) * (r.uniform() < 0.5 ? -1 : 1);
  }
}

void add_tape(Canvas& c, Random& r) {
  const double half_width = r.uniform(8, 30), half_length = r.uniform(0.3, 1.2) * c.width;
  const double bend = r.uniform(-0.12, 0.12) / half_length, most = std::abs(bend) * half_length * half_length;
  const Vec3f paper = strip_color(r), ink = ink_on(paper), red = srgb_to_linear(Vec3f(0.75f, 0.1f, 0.08f));
  const Scale scale = random_scale(half_width, r);
  const Board b = Board::turned(r.uniform(0, c.width), r.uniform(0, c.height), half_length, half_width + most,
                                angle_of_thing(r));
  lay(c, b, r.uniform(0, 10), [&](double along, double across) -> std::optional<Vec3f> {
    const double w = (across - bend * along * along) / half_width;
    if (std::abs(w) > 1) return {};
    const bool decimeter = static_cast<std::int64_t>(std::floor(along / (100 * scale.step))) % 2 == 0;
    if (scale.marked(along, w)) return decimeter && w > 0 ? red : ink;
    return paper * static_cast<float>(1.05 - 0.25 * w * w);  // a blade of steel is hollow
  });
}

void add_scale_card(Canvas& c, Random& r) {
  const double half_length = r.uniform(60, 190), half_width = half_length * r.uniform(0.3, 0.75);
  const Vec3f paper = r.uniform() < 0.7 ? strip_color(r) : paint_color(r),
              ink = r.uniform() < 0.7 ? ink_on(paper) : paint_color(r);
  const double centimeter = r.uniform(8, 30), checks = r.uniform(4, 14);
  const bool grays = r.uniform() < 0.5, checked = r.uniform() < 0.5;
  const std::uint64_t seed = r.bits();
  const Board b = Board::turned(r.uniform(0, c.width), r.uniform(0, c.height), half_length, half_width,
                                angle_of_thing(r));
  const auto odd = [](double along, double across, double size) {
    return (static_cast<std::int64_t>(std::floor(along / size)) +
            static_cast<std::int64_t>(std::floor(across / size))) %
               2 !=
           0;
  };
  lay(c, b, r.uniform(0, 8), [&](double along, double across) -> std::optional<Vec3f> {
    const double u = along / half_length, w = across / half_width;
    if (std::max(std::abs(u), std::abs(w)) > 0.97) return ink;
    if (w < -0.65 && w > -0.9) return odd(along, 0, centimeter) != (w > -0.78) ? ink : paper;
    if (w > 0.65 && w < 0.9) return odd(along, 0, 2.54 * centimeter) ? ink : paper;
    if (checked && u < -0.45 && std::abs(w) < 0.5) return odd(along, across, checks) ? ink : paper;
    if (grays && u > 0.5 && std::abs(w) < 0.5)
      return Vec3f::Constant(static_cast<float>(std::pow(2.0, std::floor(6 * (w - 0.5)))));
    const bool line = static_cast<std::int64_t>(std::floor(across / 5)) % 2 == 0;
    return line && std::abs(u) < 0.4 && std::abs(w) < 0.45 && writing(along, across, 1.7, seed) ? ink : paper;
  });
}

}  // namespace terrazzo::synthetic_photo
