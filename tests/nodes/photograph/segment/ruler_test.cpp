#include "nodes/photograph/marks/ruler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace segment;

struct Scene {
  Image image{400, 300, 1, 1, Vec3f::Constant(0.3f)};
  IgnoredPixels ignored = IgnoredPixels(400 * 300, 0);
  PixelBox box{399, 299, 0, 0};
  // Calls shade(along, across) at every pixel of a board of this size.
  template <class Shade>
  void board(double angle, double half_length, double half_width, const Shade& shade) {
    for (int y = 0; y < 300; ++y)
      for (int x = 0; x < 400; ++x) {
        const double along = std::cos(angle) * (x - 200) + std::sin(angle) * (y - 150),
                     across = std::cos(angle) * (y - 150) - std::sin(angle) * (x - 200);
        if (std::abs(along) > half_length || std::abs(across) > half_width) continue;
        // Four samples per pixel, as a camera averages.
        float sum = 0;
        for (const double u : {-0.25, 0.25})
          for (const double v : {-0.25, 0.25}) sum += shade(along + u, across + v) / 4;
        image.at(x, y).setConstant(sum);
        ignored[image.index(x, y, 0)] = 1;
        box.left = std::min(box.left, x);
        box.right = std::max(box.right, x);
        box.top = std::min(box.top, y);
        box.bottom = std::max(box.bottom, y);
      }
  }
};

// Ticks at every step, longer ones at every fifth and tenth, like millimeters.
float millimeters(double along, double w, double step, double middle) {
  const auto tick = static_cast<long>(std::floor((along - middle) / step + 0.5));
  const double reach = tick % 10 == 0 ? 0.2 : tick % 5 == 0 ? -0.2 : -0.5;
  return std::abs(along - middle - static_cast<double>(tick) * step) < 0.15 * step && w < reach ? 0.05f
                                                                                                : 0.85f;
}

TEST(Ruler, TicksAreMeasured) {
  Random random(3);
  for (int k = 0; k < 30; ++k) {
    const double step = random.uniform(4, 16), angle = random.uniform(-3, 3), middle = random.uniform(0, 5);
    Scene s;
    s.board(angle, 140, 20,
            [&](double along, double across) { return millimeters(along, across / 20, step, middle); });
    for (auto& v : s.image.pixels) v *= static_cast<float>(1 + 0.03 * random.normal());
    const auto mark = find_scale(s.image, 0, s.box, s.ignored);
    ASSERT_TRUE(mark) << step << " at " << angle;
    EXPECT_EQ(mark->kind, ScaleMark::Kind::Ticks);
    EXPECT_NEAR(mark->length, step, std::max(0.01 * step, mark->uncertainty)) << "at " << angle;
    EXPECT_LT(mark->uncertainty, 0.02 * step);
  }
}

TEST(Ruler, AFrameHasNeither) {
  Random random(4);
  Scene s;
  s.board(0.3, 150, 12, [&](double, double) { return 0.6f; });
  for (auto& v : s.image.pixels) v *= static_cast<float>(1 + 0.05 * random.normal());
  EXPECT_FALSE(find_scale(s.image, 0, s.box, s.ignored));
}

TEST(Ruler, TheBarOfACaptionIsMeasured) {
  for (const int length : {31, 80, 143}) {
    Scene s;
    s.board(0, 180, 20, [&](double along, double across) {
      const bool bar = along > -100.5 && along < -100.5 + length && across > 4.5 && across < 9.5;
      const bool letter =
          across > -12 && across < -2 && along > -90 && along < 0 && std::fmod(along + 90, 9) < 3;
      return bar || letter ? 0.95f : 0.02f;
    });
    const auto mark = find_scale(s.image, 0, s.box, s.ignored);
    ASSERT_TRUE(mark) << length;
    EXPECT_EQ(mark->kind, ScaleMark::Kind::Bar);
    EXPECT_NEAR(mark->length, length, 1);
  }
}

}  // namespace
}  // namespace terrazzo
