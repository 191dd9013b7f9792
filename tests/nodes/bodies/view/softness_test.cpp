#include "nodes/bodies/view/softness.h"

#include <gtest/gtest.h>

#include <cmath>

namespace terrazzo {
namespace {

TEST(SoftOutlines, AreAStepsIntegralAndStonesStaySharp) {
  constexpr int kWidth = 80;
  constexpr int kHeight = 20;
  std::vector<std::int32_t> stone;
  std::vector<Vec3f> picture;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      stone.push_back(x < 40 ? 1 : 2);
      const float grain = x % 2 == 0 ? 0.05F : -0.05F;
      picture.push_back(Vec3f::Constant((x < 40 ? 0.2F : 0.8F) + (std::abs(x - 40) > 15 ? grain : 0)));
    }
  const std::vector<Vec3f> before = picture;
  view::soften_outlines(picture.data(), stone, kWidth, kHeight, 2);
  for (int x = 36; x < 44; ++x) {
    const double step = 0.5 * std::erfc((40 - x - 0.5) / (2 * std::sqrt(2.0)));
    EXPECT_NEAR(picture[10 * kWidth + x].y(), 0.2 + 0.6 * step, 0.02) << x;
  }
  for (const int x : {0, 5, 20, 62, 79}) EXPECT_EQ(picture[10 * kWidth + x], before[10 * kWidth + x]) << x;
  picture = before;
  view::soften_outlines(picture.data(), stone, kWidth, kHeight, 0.2);
  EXPECT_EQ(picture, before);
}

}  // namespace
}  // namespace terrazzo
