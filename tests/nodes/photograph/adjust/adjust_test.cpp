#include "nodes/photograph/adjust/adjust.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "nodes/common/texture/color.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace adjust;

// Colors that tell where they were.
Image numbered(int width, int height) {
  Image out(width, height, 2, 0.5);
  for (std::size_t i = 0; i < out.pixels.size(); ++i) out.pixels[i] = Vec3f(0.01f * i, 0.5f, 0.3f);
  return out;
}

double luminance(const Vec3f& c) { return c.dot(Vec3f(0.213f, 0.715f, 0.072f)); }

TEST(Adjust, ChangesNothingByDefault) {
  const Image in = numbered(4, 3);
  EXPECT_EQ(adjust_image(in, {}, {}).pixels, in.pixels);
}

TEST(Adjust, CropsAllSectionsAndKeepsCoordinatesOnTheMap) {
  Image in = numbered(5, 4);
  AdjustOptions o;
  o.crop = {{1, 2, 3, 2}};
  const Image out = adjust_image(in, o, {});
  ASSERT_EQ(out.width, 3);
  ASSERT_EQ(out.height, 2);
  EXPECT_EQ(out.pixel_size, 0.5);
  for (int section = 0; section < 2; ++section)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 3; ++x) EXPECT_EQ(out.at(x, y, section), in.at(x + 1, y + 2, section));

  in.sections = 1;
  in.pixels.resize(20);
  in.georeference = Georeference{{2, 0.5, 100, 0.5, -2, 300}, 25832};
  const Image placed = adjust_image(in, o, {});
  EXPECT_TRUE(placed.georeference->on_map(Vec2(0.5, 1)).isApprox(in.georeference->on_map(Vec2(1.5, 3))));
  EXPECT_EQ(placed.georeference->epsg, 25832);
}

TEST(Adjust, MapsBlackAndWhiteAsDisplayed) {
  const Image in(1, 1, 1, 1, srgb_to_linear(Vec3f(0.2f, 0.5f, 0.8f)));
  AdjustOptions o;
  o.black = 0.2, o.white = 0.8;
  EXPECT_TRUE(adjust_image(in, o, {}).pixels[0].isApprox(srgb_to_linear(Vec3f(0, 0.5f, 1)), 1e-5f));
  o.gamma = 2;
  EXPECT_NEAR(linear_to_srgb(adjust_image(in, o, {}).pixels[0])[1], std::sqrt(0.5), 1e-5);
}

// What is brighter than white stays so, in its order, and without a step.
TEST(Adjust, GoesOnAboveWhite) {
  AdjustOptions o;
  o.white = 0.5, o.gamma = 3;
  float last = 0;
  for (const float v : {0.4999f, 0.5001f, 0.7f, 1.0f, 2.0f}) {
    const Image in(1, 1, 1, 1, srgb_to_linear(Vec3f::Constant(v)));
    const float now = linear_to_srgb(adjust_image(in, o, {}).pixels[0])[0];
    EXPECT_GT(now, last);
    EXPECT_NEAR(now, 1 + (v - 0.5) / 0.5 / 3, 1e-4) << v;
    last = now;
  }
}

TEST(Adjust, TurnsHuesAndKeepsTheLuminance) {
  const Image in(1, 1, 1, 1, Vec3f(0.5f, 0.4f, 0.3f));
  AdjustOptions o;
  for (const double angle : {-90.0, 30.0, 180.0}) {
    o.hue = angle;
    const Vec3f out = adjust_image(in, o, {}).pixels[0];
    EXPECT_NEAR(luminance(out), luminance(in.pixels[0]), 1e-3) << angle;
    EXPECT_FALSE(out.isApprox(in.pixels[0], 0.01f));
  }
  o.hue = 360;
  EXPECT_TRUE(adjust_image(in, o, {}).pixels[0].isApprox(in.pixels[0], 1e-4f));
  o.hue = 0, o.saturation = 0;
  EXPECT_TRUE(adjust_image(in, o, {}).pixels[0].isApprox(Vec3f::Constant(luminance(in.pixels[0])), 1e-3f));
  o.saturation = 10;  // beyond the gamut
  EXPECT_GE(adjust_image(in, o, {}).pixels[0].minCoeff(), 0);
}

TEST(Adjust, PassesItsParametersOn) {
  const auto run = test::run_node("Adjust", {{"image", Value::of(numbered(4, 3))}},
                                  {{"crop", "[1, 1, 2, 1]"}, {"saturation", "0"}});
  const auto& out = run.output<Image>("image");
  EXPECT_EQ(out.width, 2);
  EXPECT_NEAR(out.pixels[0][0], out.pixels[0][1], 1e-3);
}

TEST(Adjust, RefusesWhatItCannotDo) {
  const auto code = [](const std::map<std::string, std::string>& parameters, const Image& image) {
    return test::code_of([&] { test::run_node("Adjust", {{"image", Value::of(image)}}, parameters); });
  };
  EXPECT_EQ(code({{"crop", "[3, 0, 2, 1]"}}, numbered(4, 3)), "bad-region");
  EXPECT_EQ(code({{"crop", "[1000000, 1000000, 1000000, 1000000]"}}, numbered(4, 3)), "bad-region");
  EXPECT_EQ(code({{"crop", "[0, 0, 0, 1]"}}, numbered(4, 3)), "bad-region");
  EXPECT_EQ(code({{"black", "0.7"}, {"white", "0.7"}}, numbered(4, 3)), "bad-range");
  EXPECT_EQ(code({}, Image{}), "empty-image");
}

}  // namespace
}  // namespace terrazzo
