#include "nodes/common/plot/plot.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/plot/drawing.h"
#include "nodes/common/plot/plot_axis.h"
#include "nodes/common/plot/stroke_font.h"

namespace terrazzo {
namespace {

bool is(const Vec3f& c, int r, int g, int b) {  // sRGB bytes
  auto linear = [](int v) {
    return v / 255.0 <= 0.04045 ? v / 255.0 / 12.92 : std::pow((v / 255.0 + 0.055) / 1.055, 2.4);
  };
  return std::abs(c.x() - linear(r)) < 2e-3 && std::abs(c.y() - linear(g)) < 2e-3 &&
         std::abs(c.z() - linear(b)) < 2e-3;
}

Plot bars(const std::vector<double>& heights) {
  Plot plot;
  PlotSeries s;
  s.kind = PlotSeries::Kind::Bars;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    s.x.push_back(double(i));
    s.y.push_back(heights[i]);
  }
  plot.series = {s};
  return plot;
}

// Longest run of the first palette color in each column; adjacent columns with runs form bars.
std::vector<int> bar_heights(const Image& image) {
  std::vector<int> heights;
  bool within = false;
  for (int x = 0; x < image.width; ++x) {
    int count = 0;
    for (int y = 0; y < image.height; ++y) count += is(image.at(x, y), 0, 114, 178);
    if (count > 3) {
      if (!within) heights.push_back(0);
      heights.back() = std::max(heights.back(), count);
    }
    within = count > 3;
  }
  return heights;
}

TEST(Plot, BarsAreAsHighAsTheirValues) {
  const auto heights = bar_heights(draw(bars({1, 2, 4, 3})));
  ASSERT_EQ(heights.size(), 4u);
  for (int i : {0, 1, 3}) EXPECT_NEAR(heights[i], heights[2] * (i == 3 ? 3 : i + 1) / 4.0, 2.5);
  EXPECT_GT(heights[2], 250);
}

TEST(Plot, BarsStandSideBySide) {
  Plot plot = bars({3, 3});
  plot.series.push_back(plot.series[0]);
  plot.series[1].color = 1;
  const Image image = draw(plot);
  int first_only = 0, second = 0;
  for (const Vec3f& c : image.pixels) {
    first_only += is(c, 0, 114, 178);
    second += is(c, 213, 94, 0);
  }
  EXPECT_NEAR(first_only, second, 0.02 * second);
  EXPECT_GT(second, 10000);
}

TEST(Plot, LinesPassThroughTheirPointsAndBreakAtNaN) {
  Plot plot;
  PlotSeries s;
  s.x = {0, 1, 2, 3, 4};
  s.y = {1, 1, NAN, 1, 1};
  plot.series = {s};
  const Image image = draw(plot);
  int columns = 0, first = image.width, last = 0;
  for (int x = 0; x < image.width; ++x)
    for (int y = 0; y < image.height; ++y)
      if (is(image.at(x, y), 0, 114, 178)) {
        ++columns, first = std::min(first, x), last = std::max(last, x);
        break;
      }
  EXPECT_NEAR(columns, (last - first) / 2.0, 10);  // two of four spans
}

TEST(Plot, SeriesThatShareNoPlaceStandOnTheirTicks) {
  Plot plot = bars({3, NAN});
  plot.series.push_back(bars({NAN, 3}).series[0]);
  plot.series[1].color = 1;
  const Image image = draw(plot);
  int left = image.width, right = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (is(image.at(x, y), 0, 114, 178)) {
        left = std::min(left, x);
        right = std::max(right, x);
      }
  const Image alone = draw(bars({3, NAN}));
  int left_alone = image.width, right_alone = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (is(alone.at(x, y), 0, 114, 178))
        left_alone = std::min(left_alone, x), right_alone = std::max(right_alone, x);
  EXPECT_NEAR(right - left, 59, 1);  // the maximum width of bars
  EXPECT_NEAR(right_alone - left_alone, right - left, 1);
}

TEST(Plot, WhiskersShowIntervals) {
  Plot plot = bars({2, 2});
  const Image without = draw(plot);
  plot.series[0].low = {1, 1};
  plot.series[0].high = {2, 2};
  const Image with = draw(plot);
  int changed = 0;
  for (std::size_t i = 0; i < with.pixels.size(); ++i)
    changed += (with.pixels[i] - without.pixels[i]).norm() > 0.05;
  EXPECT_GT(changed, 200);
}

TEST(Plot, SurvivesWhatCannotBeDrawn) {
  Plot empty;
  EXPECT_EQ(draw(empty).width, 720);
  Plot bad = bars({NAN, INFINITY});
  bad.series[0].low = {NAN};
  bad.series[0].high = {-INFINITY};
  bad.log_y = true;
  const Image image = draw(bad);
  for (const Vec3f& c : image.pixels) ASSERT_TRUE(c.allFinite());
  Plot zero = bars({0, 0});
  zero.log_x = zero.log_y = true;
  zero.width = zero.height = -5;
  for (const Vec3f& c : draw(zero).pixels) ASSERT_TRUE(c.allFinite());
  Plot huge = bars({1e300, -1e300});
  for (const Vec3f& c : draw(huge).pixels) ASSERT_TRUE(c.allFinite());
}

TEST(Plot, SeveralStandInRows) {
  Plot small;
  small.width = 200;
  small.height = 150;
  const Image sheet = draw({small, small, small}, 2);
  EXPECT_EQ(sheet.width, 400);
  EXPECT_EQ(sheet.height, 300);
}

TEST(PlotAxis, TicksAreRoundAndCoverTheValues) {
  for (const auto& [lo, hi] :
       std::vector<std::pair<double, double>>{{0.013, 0.47}, {-3, 12}, {1e-7, 9e-7}, {100, 100000}, {5, 5}}) {
    const PlotAxis axis = make_axis({lo, hi}, false, false, false, 6);
    EXPECT_LE(axis.lo, lo);
    EXPECT_GE(axis.hi, hi);
    EXPECT_GE(axis.ticks.size(), 3u);
    EXPECT_LE(axis.ticks.size(), 9u);
    EXPECT_EQ(axis.ticks.size(), axis.words.size());
    for (std::size_t i = 0; i < axis.ticks.size(); ++i)
      EXPECT_NEAR(std::stod(axis.words[i]), axis.ticks[i], 1e-9 * (axis.hi - axis.lo));
  }
}

TEST(PlotAxis, LogTicksAreDecades) {
  const PlotAxis axis = make_axis({0.02, 700, -3}, true, false, false, 8);
  EXPECT_DOUBLE_EQ(axis.lo, 0.02);
  EXPECT_DOUBLE_EQ(axis.hi, 1000);
  ASSERT_EQ(axis.ticks.size(), 5u);
  EXPECT_NEAR(axis.ticks[0], 0.1, 1e-12);
  EXPECT_NEAR(axis.place(std::sqrt(0.02 * 1000)), 0.5, 1e-12);
}

TEST(Text, WidthIsThatOfTheWordsDrawn) {
  for (const std::string text : {"Particles 12.5 mm²", "iiiiiiii", "WWWW", "µ³°×"}) {
    Image image(400, 40, 1, 1, Vec3f::Ones());
    const int width = draw_text(image, 10, 5, text, 20, Vec3f::Zero());
    EXPECT_EQ(width, text_width(text, 20));
    int last = 0, first = 400;
    for (int x = 0; x < 400; ++x)
      for (int y = 0; y < 40; ++y)
        if (image.at(x, y).x() < 0.5f) {
          last = std::max(last, x);
          first = std::min(first, x);
        }
    EXPECT_GE(first, 10);
    EXPECT_LT(last, 10 + width);
    EXPECT_GT(last, 10 + width - 6);
  }
}

TEST(Text, SymbolsHaveTheirIndexBelowTheLine) {
  EXPECT_LT(text_width("N_A", 20), text_width("N_", 20) + text_width("A", 20) / 2);
  EXPECT_NEAR(
      text_width("area_fraction N_A_l1", 20),
      text_width("area", 20) + text_width("_fraction", 20) + text_width(" N", 20) + text_width("_A_l1", 20),
      4);
}

TEST(Text, EveryPromisedLetterHasItsOwnForm) {
  std::string all;
  for (char c = 33; c < 127; ++c) all += c;
  for (char32_t c : code_points(all + "µ²³°×")) {
    EXPECT_FALSE(glyph(c).strokes.empty()) << std::uint32_t(c);
    EXPECT_NE(&glyph(c), &glyph(U'\uFFFD')) << std::uint32_t(c);
  }
  EXPECT_EQ(&glyph(0x1F600), &glyph(U'\uFFFD'));
  EXPECT_EQ(code_points("a\xff\xe2\x82").size(), 3u);
}

TEST(Text, DrawsOnlyWithinTheImage) {
  Image image(20, 20, 1, 1, Vec3f::Ones());
  draw_text(image, -15, -8, "WWWWWW", 24, Vec3f::Zero());
  draw_text(image, 500, 500, "far away", 24, Vec3f::Zero());
  int dark = 0;
  for (const Vec3f& c : image.pixels) dark += c.x() < 0.5f;
  EXPECT_GT(dark, 10);
}

}  // namespace
}  // namespace terrazzo
