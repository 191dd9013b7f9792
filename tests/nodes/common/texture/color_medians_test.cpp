#include "nodes/common/texture/color_medians.h"

#include <gtest/gtest.h>

namespace terrazzo {
namespace {

TEST(ColorMedians, SpecksDoNotChangeAColor) {
  ColorMedians medians({9, 0, 100'000});
  for (int k = 0; k < 9; ++k) medians.add(0, k < 4 ? Vec3f(1, 1, 0) : Vec3f(0.1f, 0.2f, 0.3f));
  for (int k = 0; k < 100'000; ++k) medians.add(2, Vec3f::Constant(static_cast<float>(k) / 100'000));
  EXPECT_EQ(medians.value(0), Vec3f(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(medians.value(1), Vec3f(0, 0, 0));
  EXPECT_NEAR(medians.value(2).x(), 0.5f, 0.003f);  // of 500 pixels spread over all
}

}  // namespace
}  // namespace terrazzo
