#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/texture/color.h"
#include "nodes/compare/texture_observer/observer.h"
#include "nodes/data/table.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace texture_observer;

// Independent gray pixels around a middle gray; `deviation` in 8-bit steps.
Image gray_noise(int width, int height, std::uint64_t seed, double deviation = 25, int sections = 1) {
  Image out(width, height, sections, 0.1);
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    const double code = 128 + deviation * Random(seed, 1, i).normal();
    out.pixels[i] = srgb_to_linear(Vec3f::Constant(static_cast<float>(std::clamp(code / 255, 0.0, 1.0))));
  }
  return out;
}

const CropOptions kSmall{.crop = 32};

std::array<Verdict, 2> verdicts_on(const Image& a, const Image& b, const CropOptions& choice = kSmall) {
  return observe(halves_of(a, "a", choice, {}), halves_of(b, "b", choice, {}), choice.seed);
}

test::NodeRun run_on(const Image& a, const Image& b, const std::map<std::string, std::string>& parameters) {
  return test::run_node("TextureObserver", {{"a", Value::of(a)}, {"b", Value::of(b)}}, parameters);
}

TEST(TextureObserver, CannotTellNoiseFromOtherNoise) {
  for (const Verdict& v : verdicts_on(gray_noise(320, 256, 1), gray_noise(320, 256, 2))) {
    EXPECT_EQ(v.accuracy.crops, 2 * 2 * 5 * 8) << v.observer;
    EXPECT_NEAR(v.accuracy.share, 0.5, 3 * v.accuracy.error) << v.observer;
    EXPECT_NEAR(v.control.share, 0.5, 3 * v.control.error) << v.observer;
    EXPECT_EQ(v.giveaway(), nullptr) << v.observer;
  }
}

TEST(TextureObserver, TellsAContrast) {
  for (const Verdict& v : verdicts_on(gray_noise(256, 192, 1), gray_noise(256, 192, 2, 20))) {
    EXPECT_GT(v.accuracy.share, 0.98) << v.observer;
    EXPECT_LT(v.accuracy.error, 0.05) << v.observer;
    ASSERT_NE(v.giveaway(), nullptr) << v.observer;
  }
}

TEST(TextureObserver, SaysThatOnlyTheColorDiffers) {
  Image a = gray_noise(256, 192, 1), b = gray_noise(256, 192, 2);
  for (Image* image : {&a, &b})
    for (Vec3f& p : image->pixels) {
      Vec3f lab = linear_to_oklab(p);
      lab[image == &a ? 1 : 2] += 0.02f;  // equally colorful, another hue
      p = oklab_to_linear(lab);
    }
  const auto verdicts = verdicts_on(a, b);
  EXPECT_EQ(verdicts[0].observer, "patterns");
  EXPECT_EQ(verdicts[0].accuracy.share, 1);
  ASSERT_NE(verdicts[0].giveaway(), nullptr);
  EXPECT_EQ(verdicts[0].giveaway()->name, "color");
}

TEST(TextureObserver, GuessesBetweenAPictureAndItself) {
  const Image a = gray_noise(256, 128, 3);
  for (const Verdict& v : verdicts_on(a, a)) EXPECT_DOUBLE_EQ(v.accuracy.share, 0.5) << v.observer;
}

TEST(TextureObserver, TheControlDoesNotDependOnB) {
  const Image a = gray_noise(256, 128, 1);
  const auto x = verdicts_on(a, gray_noise(320, 192, 2)), y = verdicts_on(a, gray_noise(128, 128, 3, 5));
  for (int o = 0; o < 2; ++o) {
    EXPECT_EQ(x[o].control.share, y[o].control.share);
    EXPECT_EQ(x[o].control.crops, 4 * 8);  // a quarter of the crops in each color of each half
    EXPECT_NE(x[o].accuracy.share, y[o].accuracy.share);
  }
}

TEST(TextureObserver, ExchangingThePicturesKeepsTheAccuracy) {
  const Image a = gray_noise(256, 128, 1), b = gray_noise(192, 160, 2, 24);
  const auto x = verdicts_on(a, b), y = verdicts_on(b, a);
  for (int o = 0; o < 2; ++o) {
    EXPECT_EQ(x[o].accuracy.crops, y[o].accuracy.crops);
    // Sums are rounded in another order, which may change a crop at the very border.
    EXPECT_NEAR(x[o].accuracy.share, y[o].accuracy.share, 1.5 / x[o].accuracy.crops) << x[o].observer;
  }
}

TEST(TextureObserver, SeesWhatAReductionHides) {
  // Averages of 2 × 2 pixels are equal: the noise of a is repeated, that of b alternates around it.
  Image a(512, 256, 1, 0.1), b = a;
  const Image coarse = gray_noise(256, 128, 7, 10), other = gray_noise(256, 128, 8, 10);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 512; ++x) {
      a.at(x, y) = coarse.at(x / 2, y / 2);
      b.at(x, y) = other.at(x / 2, y / 2) * ((x + y) % 2 ? 1.05f : 0.95f);
    }
  CropOptions full = kSmall, reduced = kSmall;
  full.crops = 64;
  reduced.scale = 2;
  for (const Verdict& v : verdicts_on(a, b, full)) EXPECT_GT(v.accuracy.share, 0.98) << v.observer;
  for (const Verdict& v : verdicts_on(a, b, reduced))
    EXPECT_NEAR(v.accuracy.share, 0.5, 3 * v.accuracy.error) << v.observer;
}

TEST(TextureObserver, UsesEverySectionOfAStack) {
  const Image a = gray_noise(64, 32, 1, 25, 12), b = gray_noise(64, 32, 2, 15, 12);
  for (const Verdict& v : verdicts_on(a, b)) {
    EXPECT_EQ(v.accuracy.crops, 2 * 2 * 12) << v.observer;
    EXPECT_GT(v.accuracy.share, 0.9) << v.observer;
  }
}

TEST(TextureObserver, ReportsWhatItFinds) {
  const auto run = run_on(gray_noise(256, 192, 1), gray_noise(256, 192, 2, 18), {{"crop", "32"}});
  const Table& t = run.output<Table>("table");
  ASSERT_EQ(t.rows.size(), 2u);
  EXPECT_EQ(run.metrics.at("accuracy_patterns"), t.number(0, "accuracy %") / 100);
  EXPECT_EQ(run.metrics.at("accuracy_features"), t.number(1, "accuracy %") / 100);
  EXPECT_EQ(run.metrics.at("accuracy"),
            std::max(run.metrics.at("accuracy_patterns"), run.metrics.at("accuracy_features")));
  EXPECT_GT(run.output<Image>("figure").width, 0);
  EXPECT_TRUE(run.warnings.empty());
}

TEST(TextureObserver, WarnsOfFewCrops) {
  const auto run = run_on(gray_noise(128, 96, 1), gray_noise(128, 96, 2), {{"crop", "32"}});
  ASSERT_FALSE(run.warnings.empty());
  EXPECT_NE(run.warnings.back().find("24 crops"), std::string::npos) << run.warnings.back();
}

TEST(TextureObserver, BadInputIsNamed) {
  const Image good = gray_noise(128, 96, 1);
  const auto code = [&](const Image& a, const Image& b, const char* crop) {
    return test::code_of([&] { run_on(a, b, {{"crop", crop}}); });
  };
  EXPECT_EQ(code(good, Image{}, "32"), "empty-image");
  EXPECT_EQ(code(good, gray_noise(126, 96, 1), "64"), "too-small");
  EXPECT_EQ(code(gray_noise(64, 32, 1), good, "32"), "too-small");  // one crop in each half
  EXPECT_EQ(code(good, good, "36"), "bad-value");
  Image coarse = good, bad = good;
  coarse.pixel_size *= 1.03;
  EXPECT_EQ(code(good, coarse, "32"), "size-mismatch");
  bad.pixels[128 * 40 + 3][1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(code(good, bad, "32"), "bad-pixels");
  EXPECT_EQ(code(good, good, "32"), "");
}

}  // namespace
}  // namespace terrazzo
