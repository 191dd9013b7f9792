#include "nodes/detail/residual/outline_depth.h"

#include <gtest/gtest.h>

#include <vector>

#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

// Bars across x, with binder between them: 6 pixels wide, then 30.
std::vector<std::int32_t> bars(int width, int height) {
  std::vector<std::int32_t> ids(pixels_in(width, height), 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int at = x % 56;
      ids[pixel_at(x, y, width)] = at < 10 ? 1 : at < 16 ? 0 : at < 26 ? 2 : 0;
    }
  return ids;
}

TEST(BinderWidth, IsHalfTheGapAllOverIt) {
  const int width = 112, height = 90;
  const std::vector<float> w = residual::binder_width(bars(width, height).data(), width, height, true);
  const auto at = [&](int x, int y) { return w[pixel_at(x, y, width)]; };
  for (const int y : {3, 45, 88}) {
    for (int x = 10; x < 16; ++x) EXPECT_NEAR(at(x, y), 3, 1) << x;
    for (int x = 30; x < 52; ++x) EXPECT_NEAR(at(x, y), 15, 2) << x;
    EXPECT_EQ(at(5, y), at(5, 45)) << "all rows are alike";
  }
}

TEST(BinderWidth, WithoutParticlesIsTheWidest) {
  const std::vector<std::int32_t> none(pixels_in(40, 30), 0);
  for (const float w : residual::binder_width(none.data(), 40, 30, false)) EXPECT_NEAR(w, 64, 8);
}

// A gap of 80 pixels that crosses the edge of a tile: 75 pixels lie at the right edge and 5 at the left.
TEST(BinderWidth, GoesOnAcrossTheEdgesOfATile) {
  std::vector<std::int32_t> ids(pixels_in(300, 40), 1);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 300; ++x)
      if (x < 5 || x >= 225) ids[pixel_at(x, y, 300)] = 0;
  const auto w = residual::binder_width(ids.data(), 300, 40, true);
  EXPECT_NEAR(w[pixel_at(0, 20, 300)], 40, 4);
  EXPECT_NEAR(w[pixel_at(0, 20, 300)], w[pixel_at(299, 20, 300)], 0.1);
}

// The same picture in pixels half as large.
TEST(BinderWidth, KeepsItsReachInFinerPictures) {
  std::vector<std::int32_t> fine(pixels_in(400, 200), 0);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 400; ++x) fine[pixel_at(x, y, 400)] = x < 150 || x >= 250;  // a gap of 100 pixels
  const auto w = residual::binder_width(fine.data(), 400, 200, false, 2);
  EXPECT_NEAR(w[pixel_at(200, 100, 400)], 50, 5);
  const auto capped = residual::binder_width(fine.data(), 400, 200, false, 0.5);
  EXPECT_NEAR(capped[pixel_at(200, 100, 400)], 32, 4);
}

}  // namespace
}  // namespace terrazzo
