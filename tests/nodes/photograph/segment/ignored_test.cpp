// What is not material: it is not observed, and what it cuts has no weight.
#include <gtest/gtest.h>

#include <algorithm>
#include <locale>
#include <map>

#include "nodes/photograph/marks/ignored.h"
#include "nodes/photograph/segment/measure/measure.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

TEST(Ignored, AreasAreRead) {
  EXPECT_EQ(read_area("1 2 5 7").size(), 4u);
  EXPECT_EQ(read_area("0,0, 10,0, 5,8").size(), 3u);
  for (const char* text :
       {"", "1 2 3", "1 2 3 4 5", "a b c d", "1 2 3 nan", "1 2 3 4 x", "1 2 3 +-4", "1 2 3 4e999"})
    EXPECT_EQ(test::code_of([&] { read_area(text); }), "bad-region") << text;
}

// A host program may write numbers with a decimal comma.
TEST(Ignored, AreasAreReadInAnyLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const Area area = read_area("1.5 2 5.25,7");
  std::locale::global(before);
  EXPECT_EQ(area[0].x(), 1.5);
  EXPECT_EQ(area[2].x(), 5.25);
}

TEST(Ignored, RectanglesAndPolygonsCoverTheirPixels) {
  const Image image(20, 12, 2, 1);
  const auto count = [](const IgnoredPixels& p) { return std::count(p.begin(), p.end(), 1); };
  EXPECT_EQ(count(ignored_pixels(image, {read_area("2 3 7 9")}, nullptr)), 2 * 5 * 6);
  // Corners in any order, and outside of the picture.
  EXPECT_EQ(count(ignored_pixels(image, {read_area("7 9 2 3")}, nullptr)), 2 * 5 * 6);
  EXPECT_EQ(count(ignored_pixels(image, {read_area("-100 -100 4 4")}, nullptr)), 2 * 4 * 4);
  EXPECT_EQ(count(ignored_pixels(image, {read_area("0 0 10 0 0 10")}, nullptr)),
            2 * 45);  // a half of 10 × 10
  EXPECT_TRUE(ignored_pixels(image, {read_area("30 0 40 5")}, nullptr).empty());
  EXPECT_EQ(test::code_of([&] { ignored_pixels(image, {read_area("0 0 20 12")}, nullptr); }), "empty-image");
  Labels mask;
  mask.width = 20;
  mask.height = 12;
  mask.ids.assign(240, 0);
  mask.classes = {0};
  EXPECT_EQ(test::code_of([&] { ignored_pixels(image, {}, &mask); }), "size-mismatch");
}

TEST(Ignored, CoveredPixelsMirrorWhatIsBesideThem) {
  const Image plain(9, 5, 1, 1);
  Image image = plain;
  IgnoredPixels ignored(45, 0);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 9; ++x) {
      image.at(x, y) = Vec3f::Constant(static_cast<float>(10 * y + x));
      ignored[plain.index(x, y)] = x >= 3 && x < 8;
    }
  cover_ignored(image, 0, ignored);
  const int from[] = {0, 1, 2, 1, 0, 2, 8, 8, 8};  // nothing is behind columns 0 and 8
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 9; ++x)
      if (x != 5) {  // as near to both edges
        EXPECT_EQ(image.at(x, y)[0], static_cast<float>(10 * y + from[x])) << x << ' ' << y;
      }
}

// What a mask leaves of a particle counts as a speck if it is smaller than min_area.
TEST(Ignored, CutParticlesAreSpecks) {
  Image image(60, 40, 1, 1, Vec3f::Constant(0.7f));
  const auto square = [&](int left, int top) {
    for (int y = top; y < top + 12; ++y)
      for (int x = left; x < left + 12; ++x) image.at(x, y).setConstant(0.1f);
  };
  square(5, 5);
  square(25, 5);
  square(10, 26);
  square(40, 20);
  const auto found = test::run_node(
      "Segment", {{"image", Value::of(image)}},
      {{"method", "clusters"}, {"binder", "lightest"}, {"min_area", "40"}, {"ignore", "[0 28 60 40]"}});
  EXPECT_EQ(found.output<Profiles>("profiles").profiles.size(), 3u);  // 24 pixels of the third are seen
}

TEST(Ignored, PositionsAgainstBruteForce) {
  Random random(4);
  for (int round = 0; round < 20; ++round) {
    const int w = 12 + static_cast<int>(random.below(8)), h = 9 + static_cast<int>(random.below(8));
    IgnoredPixels ignored(static_cast<std::size_t>(w) * h, 0);
    if (round > 0)
      for (auto& v : ignored) v = random.uniform() < 0.03;
    const Positions positions(ignored.data(), w, h);
    for (int pw = 1; pw < 6; ++pw)
      for (int ph = 1; ph < 6; ++ph) {
        std::int64_t n = 0;
        for (int y = 1; y + ph < h; ++y)
          for (int x = 1; x + pw < w; ++x) {
            bool free = true;
            for (int v = y - 1; v <= y + ph; ++v)
              for (int u = x - 1; u <= x + pw; ++u)
                free = free && ignored[static_cast<std::size_t>(v) * w + u] == 0;
            n += free;
          }
        EXPECT_EQ(positions.count(pw, ph), n);
        if (round == 0) {
          EXPECT_EQ(n, static_cast<std::int64_t>(w - pw - 1) * (h - ph - 1));
        }
      }
  }
}

// Squares at random places behind a ruler: Σ weight / observed area stays an unbiased density.
TEST(Ignored, WeightsKeepTheDensityUnbiased) {
  const int W = 64, H = 64, side = 5;
  IgnoredPixels ignored(W * H, 0);
  for (int y = 40; y < 50; ++y)
    for (int x = 10; x < 64; ++x) ignored[y * W + x] = 1;
  double sum = 0;
  int trials = 0;
  // All places of one square on a torus larger than the picture, so that every place is equally likely.
  for (int py = -side; py < H; ++py)
    for (int px = -side; px < W; ++px) {
      ++trials;
      Image image(W, H, 1, 1);
      Labels labels;
      labels.width = W;
      labels.height = H;
      labels.ids.assign(W * H, 0);
      labels.classes = {0};
      std::vector<float> coverage(W * H, 0);
      bool any = false;
      for (int y = std::max(0, py); y < std::min(H, py + side); ++y)
        for (int x = std::max(0, px); x < std::min(W, px + side); ++x)
          if (!ignored[y * W + x]) labels.ids[y * W + x] = 1, coverage[y * W + x] = 1, any = true;
      if (!any) continue;
      const Profiles p = measure_profiles(image, labels, coverage, ignored, {}, {});
      EXPECT_EQ(p.observed_area, W * H - 540);
      for (const auto& q : p.profiles) sum += q.weight / p.observed_area;
    }
  EXPECT_NEAR(sum / trials, 1.0 / trials, 1e-9);
}

// Discs on a binder with a strip of another color below, as a caption would be.
Image discs_above_a_strip() {
  Image image(96, 80, 1, 0.5, Vec3f::Constant(0.7f));
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 96; ++x) {
      if ((x % 24 - 12) * (x % 24 - 12) + (y % 24 - 12) * (y % 24 - 12) < 49)
        image.at(x, y).setConstant(0.1f);
      if (y >= 64) image.at(x, y) = Vec3f(0.8f, 0.1f, 0.1f);
    }
  return image;
}

TEST(Ignored, SegmentLeavesAreasOut) {
  const Image image = discs_above_a_strip();
  Labels mask;
  mask.width = 96;
  mask.height = 80;
  mask.pixel_size = 0.5;
  for (int i = 0; i < 96 * 80; ++i) mask.ids.push_back(i >= 64 * 96);
  mask.classes = {0};
  const std::map<std::string, std::string> plain{{"method", "clusters"}, {"binder", "lightest"}};
  auto with_area = plain;
  with_area["ignore"] = "[0 64 96 80]";
  const auto a = test::run_node("Segment", {{"image", Value::of(image)}}, with_area);
  const auto b = test::run_node("Segment", {{"image", Value::of(image)}, {"mask", Value::of(mask)}}, plain);
  for (const auto* run : {&a, &b}) {
    const Profiles& p = run->output<Profiles>("profiles");
    EXPECT_EQ(p.profiles.size(), 12u);  // three rows of four, the last one cut by the strip
    EXPECT_DOUBLE_EQ(p.observed_area, 0.25 * 96 * 64);
    EXPECT_EQ(std::count_if(p.profiles.begin(), p.profiles.end(),
                            [](const Profile& q) { return q.touches_border; }),
              4);
    for (const Profile& q : p.profiles) EXPECT_EQ(q.weight == 0, q.touches_border);
    EXPECT_NEAR(p.binder_color[0], 0.7f, 0.02f);
  }
  EXPECT_EQ(a.output<Labels>("labels").ids, b.output<Labels>("labels").ids);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Segment", {{"image", Value::of(image)}}, {{"ignore", "[1 2 3]"}});
            }),
            "bad-region");
}

}  // namespace
}  // namespace terrazzo
