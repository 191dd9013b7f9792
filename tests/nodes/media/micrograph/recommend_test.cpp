#include "nodes/media/micrograph/recommend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::media {
namespace {

PhaseMap map_of(int side, const std::function<bool(int, int)>& in) {
  PhaseMap out{side, side, 2, 1, {}};
  out.at.resize(pixels_in(side, side));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) out.at[out.index(x, y)] = in(x, y);
  return out;
}

// An L of three squares of edge a has the area 3a², its convex hull 3.5a².
TEST(Recommend, CompactnessIsTheShareOfTheConvexHull) {
  EXPECT_NEAR(compactness(map_of(64, [](int x, int y) { return x % 32 < 20 && y % 32 < 9; })), 1, 1e-12);
  const auto is_l = [](int x, int y) {
    return x % 32 < 20 && y % 32 < 20 && !(x % 32 >= 10 && y % 32 >= 10);
  };
  EXPECT_NEAR(compactness(map_of(64, is_l)), 3 / 3.5, 1e-12);
}

TEST(Recommend, APhaseThatSurroundsTheOtherDoesNotCount) {
  // The rest of a picture with one small cross is convex.
  const auto cross = [](int x, int y) {
    return (std::abs(x - 32) < 2 && std::abs(y - 32) < 12) || (std::abs(y - 32) < 2 && std::abs(x - 32) < 12);
  };
  EXPECT_EQ(compactness(map_of(64, cross)), 0);  // and the cross is one piece
}

TEST(Recommend, DiscsAreParticlesAndBandsArePhases) {
  const auto picture = [](const std::function<bool(int, int)>& in) {
    Image out(640, 200, 1, 0.1);
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) out.at(x, y) = Vec3f::Constant(in(x, y) ? 0.7f : 0.05f);
    return out;
  };
  const auto discs =
      recommend(picture([](int x, int y) { return std::hypot(x % 40 - 20, y % 40 - 20) < 14; }), {});
  EXPECT_FALSE(discs.phases);
  EXPECT_NE(discs.why.find("convex hulls"), std::string::npos) << discs.why;
  const auto bands =
      recommend(picture([](int x, int y) { return std::sin(0.3 * x + 3 * std::sin(0.15 * y)) > 0; }), {});
  EXPECT_TRUE(bands.phases);
  EXPECT_FALSE(recommend(picture([](int, int) { return true; }), {}).phases);
  // Dither of one 8-bit step.
  Image dithered(100, 100, 1, 0.1);
  for (int i = 0; i < 10000; ++i)
    dithered.pixels[i] = srgb_to_linear(Vec3f::Constant(static_cast<float>(120 + i % 2) / 255));
  EXPECT_FALSE(recommend(dithered, {}).phases);
}

}  // namespace
}  // namespace terrazzo::media
