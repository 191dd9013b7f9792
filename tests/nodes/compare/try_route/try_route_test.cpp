// Which ways to a solid are tried.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/data/image.h"
#include "nodes/data/profiles.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

Image drawn(bool (*bright)(int x, int y)) {
  Image out(96, 96, 1, 0.1);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x) out.at(x, y) = Vec3f::Constant(bright(x, y) ? 0.8f : 0.1f);
  return out;
}

TEST(TryRoute, PassesWhatThePhotographShowsOrWasAskedFor) {
  const Image discs = drawn([](int x, int y) { return std::hypot(x % 32 - 16, y % 32 - 16) < 11; });
  const Image bands = drawn([](int x, int y) { return std::sin(0.3 * x + 3 * std::sin(0.15 * y)) > 0; });
  const auto code = [](const Image& image, const char* route, const char* asked) {
    return test::code_of([&] {
      const auto run =
          test::run_node("TryRoute", {{"image", Value::of(image)}}, {{"route", route}, {"asked", asked}});
      EXPECT_EQ(run.output<Image>("image").pixels, image.pixels);
    });
  };
  EXPECT_EQ(code(discs, "particles", "auto"), "");
  EXPECT_EQ(code(discs, "phases", "auto"), "shows-particles");
  EXPECT_EQ(code(bands, "particles", "auto"), "shows-phases");
  EXPECT_EQ(code(bands, "phases", "auto"), "");
  for (const Image& image : {discs, bands}) {
    EXPECT_EQ(code(image, "exemplar", "auto"), "");
    EXPECT_EQ(code(image, "phases", "phases"), "");
    EXPECT_EQ(code(image, "particles", "particles"), "");
    EXPECT_EQ(code(image, "particles", "phases"), "not-asked");
    EXPECT_EQ(code(image, "exemplar", "phases"), "not-asked");
  }
}

TEST(TryRoute, MostProfilesAreCertain) {
  const Image discs = drawn([](int x, int y) { return std::hypot(x % 32 - 16, y % 32 - 16) < 11; });
  const auto code = [&](int uncertain, const char* asked) {
    Profiles found;
    found.profiles.resize(8);
    for (int k = 0; k < uncertain; ++k) found.profiles[k].confidence = 0.3;
    return test::code_of([&] {
      test::run_node("TryRoute", {{"image", Value::of(discs)}, {"profiles", Value::of(found)}},
                     {{"asked", asked}});
    });
  };
  EXPECT_EQ(code(2, "auto"), "");
  EXPECT_EQ(code(3, "auto"), "shows-no-particles");
  EXPECT_EQ(code(8, "particles"), "");
}

// A texture is made where nothing else convinces.
TEST(TryRoute, ATextureIsTheLastWay) {
  const Value image = Value::of(Image(8, 8, 1, 0.1));
  const auto observers = [](double a, double b) {
    return Value::of(Table{{"observer", "accuracy %"}, {{"patterns", a}, {"features", b}}});
  };
  const auto code = [&](std::multimap<std::string, Value> inputs, const char* asked = "auto") {
    inputs.emplace("image", image);
    return test::code_of([&] {
      test::run_node("TryRoute", inputs, {{"route", "exemplar"}, {"asked", asked}});
    });
  };
  EXPECT_EQ(code({}), "");
  EXPECT_EQ(code({{"observers", observers(60, 89)}}), "not-wanted");
  EXPECT_EQ(code({{"observers", observers(60, 89)}}, "exemplar"), "");
  EXPECT_EQ(code({{"observers", observers(95, 60)}}), "");
  EXPECT_EQ(code({{"observers", observers(95, 60)}, {"phases", Value::of(Volume{})}}), "not-wanted");
  EXPECT_EQ(code({{"phases", Value::of(Volume{})}}, "exemplar"), "");
}

}  // namespace
}  // namespace terrazzo
