#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/texture/noise.h"
#include "nodes/solids/pattern/pattern.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

TEST(Pattern, NoiseIsBoundedContinuousAndOfMeanZero) {
  double sum = 0;
  for (int i = 0; i < 20000; ++i) {
    Random r(1, 2, static_cast<std::uint64_t>(i));
    const Vec3 p(r.uniform(-50, 50), r.uniform(-50, 50), r.uniform(-50, 50));
    const double v = noise(3, p);
    sum += v;
    ASSERT_LE(std::abs(v), 1.1);
    ASSERT_LT(std::abs(noise(3, p + Vec3(1e-4, -1e-4, 1e-4)) - v), 2e-3);
  }
  EXPECT_LT(std::abs(sum / 20000), 0.01);
}

// Sections across different axes show one body: where two planes meet, their colors agree.
TEST(Pattern, SectionsBelongToOneBody) {
  for (const char* kind : {"wood", "marble", "muscle", "fat", "bone"}) {
    const auto section = [&](const char* axis, const char* offset) {
      return test::run_node("Pattern", {},
                            {{"kind", kind},
                             {"axis", axis},
                             {"offset", offset},
                             {"width", "64"},
                             {"height", "64"},
                             {"pixel_size", "0.02"}})
          .output<Image>("image");
    };
    const Image x = section("x", "0.65"), z = section("z", "0.65");  // both contain the line at pixel 32
    double error = 0, spread = 0;
    for (int i = 0; i < 64; ++i) {
      error += (x.at(i, 64 - 1 - 32) - z.at(32, 64 - 1 - i)).norm();
      spread += (x.at(i, 0) - x.at((i + 17) % 64, 63)).norm();
    }
    EXPECT_LT(error, 0.35 * spread) << kind;
  }
}

TEST(Pattern, FibersRunAlongZ) {
  for (const char* kind : {"wood", "muscle"}) {
    const auto r = test::run_node("Pattern", {}, {{"kind", kind}, {"axis", "x"}});
    const Image& image = r.output<Image>("image");
    double along = 0, across = 0;
    for (int y = 0; y + 1 < image.height; ++y)
      for (int x = 0; x + 1 < image.width; ++x)
        along += (image.at(x, y + 1) - image.at(x, y)).norm(),
            across += (image.at(x + 1, y) - image.at(x, y)).norm();
    EXPECT_LT(along, 0.7 * across) << kind;
  }
}

TEST(Pattern, EqualForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  const auto image = [](const char* seed, int threads) {
    return test::run_node("Pattern", {}, {{"seed", seed}}, {}, threads).output<Image>("image").pixels;
  };
  EXPECT_EQ(image("1", 1), image("1", 3));
  EXPECT_NE(image("1", 1), image("2", 1));
}

}  // namespace
}  // namespace terrazzo
