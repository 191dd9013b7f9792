#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "nodes/common/io/stroke_text.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/common/texture/texture_measures.h"
#include "nodes/cooccurrence/texture_nib/nib.h"
#include "nodes/cooccurrence/texture_nib/region.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace texture_nib;

Image pattern(const std::string& kind, int size, const std::string& scale = "2",
              const std::string& seed = "1") {
  return test::run_node("Pattern", {},
                        {{"kind", kind},
                         {"axis", kind == "wood" ? "x" : "z"},
                         {"scale", scale},
                         {"seed", seed},
                         {"width", std::to_string(size)},
                         {"height", std::to_string(size)}})
      .output<Image>("image");
}

Strokes strokes_of(const std::vector<std::string>& texts) {
  Strokes s;
  for (const auto& t : texts) s.strokes.push_back(strokes::read_stroke(t));
  return s;
}

Nib nib_on(const Image& picture, const std::vector<double>& region, Finish finish, NibOptions s = {},
           std::uint64_t seed = 1, Pairs pairs = Pairs::Touching) {
  return Nib(picture, learn(picture, region_mask(region, picture.width, picture.height), s),
             {.finish = finish, .pairs = pairs, .seed = seed});
}

std::set<std::uint32_t> pixels(const std::vector<std::uint32_t>& v) {
  const std::set<std::uint32_t> out(v.begin(), v.end());
  EXPECT_EQ(out.size(), v.size());
  return out;
}

TEST(Footprint, IsWhatItsCentersSay) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random r(seed, 5);
    const Vec2 a(r.uniform(-5, 35), r.uniform(-5, 25)),
        b = seed % 4 ? Vec2(r.uniform(-5, 35), r.uniform(-5, 25)) : a;
    const double radius = r.uniform(0.5, 8);
    const auto got = pixels(capsule(30, 20, a, b, radius));
    const std::vector<std::vector<Vec2>> outlines = {{a, b, Vec2(r.uniform(0, 30), r.uniform(0, 20))},
                                                     {Vec2(3, 3), Vec2(20, 4), Vec2(18, 15), Vec2(4, 14)}};
    const auto area = pixels(surrounded(30, 20, outlines));
    for (std::uint32_t p = 0; p < 600; ++p) {
      const Vec2 c(p % 30 + 0.5, p / 30 + 0.5);
      double nearest = 1e9;
      for (int i = 0; i <= 2000; ++i) nearest = std::min(nearest, (a + (b - a) * (i / 2000.0) - c).norm());
      if (std::abs(nearest - radius) > 0.02) {
        EXPECT_EQ(got.count(p), nearest < radius);
      }
      bool in = false;
      for (const auto& line : outlines)
        for (std::size_t i = 0; i < line.size(); ++i) {
          const Vec2 u = line[i], v = line[(i + 1) % line.size()];
          if ((u.y() > c.y()) != (v.y() > c.y()) &&
              c.x() < (v.x() - u.x()) * (c.y() - u.y()) / (v.y() - u.y()) + u.x())
            in = !in;
        }
      EXPECT_EQ(area.count(p), in) << p;
    }
  }
}

// The incrementally updated matrix equals a new measurement, whatever is painted, in any order and with any
// finish.
TEST(TextureNib, MatrixAndOccupancyKeepUp) {
  const Image picture = pattern("fat", 64, "0.7");
  for (const Finish finish : {Finish::Levels, Finish::Colors, Finish::Patches})
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      NibOptions s;
      s.levels = seed == 3 ? 20 : 5;
      s.extent = 1 + static_cast<int>(seed % 3);
      s.scales = 1 + static_cast<int>(seed % 2);
      if (seed == 2) s.threshold = 0.03;
      const Pairs pairs = seed == 4 ? Pairs::Painted : Pairs::Touching;
      Nib nib = nib_on(picture, {2, 2, 40, 40}, finish, s, seed, pairs);
      std::vector<std::uint8_t> covered(64 * 64, 0);
      Random r(seed, 8);
      for (int k = 0; k < 5; ++k) {
        Stroke stroke;
        stroke.radius = r.uniform(1, 7);
        stroke.parts.resize(1);
        for (int i = 0; i < 3; ++i) stroke.parts[0].emplace_back(r.uniform(-5, 69), r.uniform(-5, 69));
        nib.paint(stroke);
        for (const auto p : footprint_of(stroke, 64, 64)) covered[p] = 1;
        ASSERT_EQ(nib.counts(), nib.fresh_counts());
        EXPECT_EQ(nib.occupancy(), covered);
      }
      // Unpainted pixels are unchanged. Painted pixels have a level and, with Levels, that level's color.
      for (std::size_t i = 0; i < covered.size(); ++i)
        if (!covered[i]) {
          EXPECT_EQ(nib.picture().pixels[i], picture.pixels[i]);
        } else {
          ASSERT_NE(nib.base_relative()[i], kNoLevel);
          if (finish == Finish::Levels) {
            EXPECT_EQ(nib.picture().pixels[i], nib.texture().levels.color[nib.base_relative()[i]]);
          }
        }
    }
}

// Section 4.1 of the paper: the working matrix comes from drawn pixels alone, so the surroundings have no
// influence.
TEST(TextureNib, WithPaintedPairsTheSurroundingsDoNotMatter) {
  const Image picture = pattern("fat", 64, "0.7");
  Image other = picture;  // the region stays, its surroundings change
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      if (x >= 30) other.pixels[picture.index(x, y)] = picture.pixels[picture.index(63 - x, 63 - y)];
  const Stroke stroke = strokes::read_stroke("5: 40 20, 52 44");
  for (const Pairs pairs : {Pairs::Touching, Pairs::Painted}) {
    Nib a = nib_on(picture, {0, 0, 30, 64}, Finish::Levels, {}, 1, pairs),
        b = nib_on(other, {0, 0, 30, 64}, Finish::Levels, {}, 1, pairs);
    a.paint(stroke);
    b.paint(stroke);
    std::size_t different = 0;
    for (const auto p : footprint_of(stroke, 64, 64))
      different += a.base_relative()[p] != b.base_relative()[p];
    if (pairs == Pairs::Painted)
      EXPECT_EQ(different, 0u);
    else
      EXPECT_GT(different, 0u);
  }
}

// Painted pixels encode to the levels counted in the matrix; their colors are the region's.
TEST(TextureNib, PaintedColorsHaveTheirLevel) {
  const Image picture = pattern("marble", 64);
  for (const Finish finish : {Finish::Levels, Finish::Colors, Finish::Patches}) {
    Nib nib = nib_on(picture, {0, 0, 64, 30}, finish);
    nib.paint(strokes::read_stroke("6: 10 40, 50 50"));
    for (std::size_t i = 0; i < nib.occupancy().size(); ++i)
      if (nib.occupancy()[i]) {
        EXPECT_EQ(nib.texture().levels.nearest(nib.texture().levels.position(nib.picture().pixels[i])),
                  nib.base_relative()[i]);
      }
  }
}

TEST(TextureNib, StrokesGivenPointByPointAreTheSame) {
  const Image picture = pattern("fat", 80);
  const Stroke stroke = strokes::read_stroke("5: 20 20, 24 30, 40 42, 39 60");
  Nib whole = nib_on(picture, {0, 0, 80, 80}, Finish::Patches), parts = whole, twice = whole;
  whole.paint(stroke);
  parts.begin_stroke(stroke.radius);
  for (const auto& p : stroke.parts[0]) parts.extend_stroke(p);
  twice.paint(stroke);
  EXPECT_EQ(whole.picture().pixels, parts.picture().pixels);
  EXPECT_EQ(whole.picture().pixels, twice.picture().pixels);
}

TEST(TextureNib, ErrorFallsWithPasses) {
  const Image picture = pattern("fat", 96, "0.6");
  std::vector<double> error;
  for (const int passes : {1, 2, 6}) {
    Nib nib(picture, learn(picture, std::vector<std::uint8_t>(96 * 96, 1), {}),
            {.passes = passes, .finish = Finish::Levels});
    nib.paint(strokes::read_stroke("30: 48 48"));
    error.push_back(nib.error());
  }
  EXPECT_LT(error[1], error[0]);
  EXPECT_LT(error[2], error[1]);
  EXPECT_LT(error[2], 3e-3);
}

// An object of other colors and one of the texture's own both disappear completely.
TEST(TextureNib, ErasesWhatLiesUnderIt) {
  const Image clean = pattern("fat", 96, "0.7");
  for (const bool alien : {true, false}) {
    Image spoilt = clean;
    for (const auto p : footprint_of(strokes::read_stroke("14: 48 48"), 96, 96))
      spoilt.pixels[p] = alien ? Vec3f(0, 0.9f, 0.1f) : clean.pixels[0];
    const auto r = test::run_node(
        "TextureNib", {{"image", Value::of(spoilt)}, {"strokes", Value::of(strokes_of({"16: 48 48"}))}});
    const Image& got = r.output<Image>("image");
    std::size_t left = 0;
    for (const auto p : footprint_of(strokes::read_stroke("14: 48 48"), 96, 96))
      left += got.pixels[p] == spoilt.pixels[p];
    EXPECT_LE(left, 3u);
    const Image& base = r.output<Image>("base_relative");
    EXPECT_NE(base.at(48, 48), Vec3f(1, 0, 1));
  }
}

// Patches inside the repaired disc are as similar to those of untouched discs (including the content it hid)
// as these are to each other.
TEST(TextureNib, RepairedRegionLooksLikeTheRest) {
  for (const char* kind : {"fat", "wood", "marble"}) {
    const int n = 128;
    const Image clean = pattern(kind, n, kind[0] == 'f' ? "0.8" : "2");
    const auto disc = [&](const Vec2& at) {
      TexturePart part{&clean, std::vector<std::uint8_t>(n * n, 0)};
      for (const auto p : capsule(n, n, at, at, 20)) part.mask[p] = 1;
      return part;
    };
    const std::vector<Vec2> places = {{64, 64}, {24, 24}, {104, 40}, {48, 104}};
    TexturePart repaired = disc(places[0]);
    Image spoilt = clean;
    for (std::size_t i = 0; i < repaired.mask.size(); ++i)
      if (repaired.mask[i]) spoilt.pixels[i] = Vec3f(0.7f, 0.05f, 0.05f);
    const auto r = test::run_node(
        "TextureNib", {{"image", Value::of(spoilt)}, {"strokes", Value::of(strokes_of({"22: 64 64"}))}});
    repaired.image = &r.output<Image>("image");
    double worst = 0, mean = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        worst = std::max(worst, patch_distance(disc(places[i]), disc(places[j])));
    for (std::size_t i = 1; i < places.size(); ++i) mean += patch_distance(repaired, disc(places[i])) / 3;
    EXPECT_LE(mean, worst) << kind;
  }
}

TEST(TextureNib, RegionsAreRectanglesPolygonsAndMasks) {
  const Image picture = pattern("fat", 64);
  const Value image = Value::of(picture), strokes = Value::of(strokes_of({"5: 50 50"}));
  const auto run = [&](const std::string& region) {
    return test::run_node("TextureNib", {{"image", image}, {"strokes", strokes}}, {{"region", region}})
        .output<Image>("image");
  };
  EXPECT_EQ(run("[4, 4, 30, 30]").pixels, run("[4, 4, 34, 4, 34, 34, 4, 34]").pixels);
  Image mask(64, 64, 1, 1);
  for (int y = 4; y < 34; ++y)
    for (int x = 4; x < 34; ++x) mask.at(x, y) = Vec3f::Ones();
  EXPECT_EQ(
      test::run_node("TextureNib", {{"image", image}, {"strokes", strokes}, {"region_mask", Value::of(mask)}})
          .output<Image>("image")
          .pixels,
      run("[4, 4, 30, 30]").pixels);
  // Fill a mask as an area.
  Image fill(64, 64, 1, 1);
  for (int y = 40; y < 50; ++y)
    for (int x = 40; x < 60; ++x) fill.at(x, y) = Vec3f::Ones();
  EXPECT_EQ(test::run_node("TextureNib", {{"image", image}, {"fill", Value::of(fill)}},
                           {{"region", "[4, 4, 30, 30]"}})
                .output<Image>("image")
                .pixels,
            test::run_node(
                "TextureNib",
                {{"image", image}, {"strokes", Value::of(strokes_of({"area: 40 40, 60 40, 60 50, 40 50"}))}},
                {{"region", "[4, 4, 30, 30]"}})
                .output<Image>("image")
                .pixels);
}

TEST(TextureNib, RefusesBadInput) {
  const Value image = Value::of(pattern("fat", 48));
  const auto code = [&](const std::vector<std::string>& strokes, std::map<std::string, std::string> p,
                        const Value& picture) {
    return test::code_of([&] {
      test::run_node("TextureNib", {{"image", picture}, {"strokes", Value::of(strokes_of(strokes))}}, p);
    });
  };
  EXPECT_EQ(code({"5: 100 100"}, {}, image), "outside-image");
  EXPECT_EQ(code({"5: 10 10", "5: -20 10"}, {}, image), "outside-image");
  EXPECT_EQ(code({"25: 10 10"}, {}, image), "nib-too-large");
  EXPECT_EQ(code({"5: 10 10"}, {{"region", "[0, 0, 3, 3]"}}, image), "too-small");
  EXPECT_EQ(code({"5: 10 10"}, {{"region", "[0, 0, 60, 20]"}}, image), "outside-image");
  EXPECT_EQ(code({"5: 10 10"}, {{"region", "[0, 0, -5, 20]"}}, image), "bad-region");
  EXPECT_EQ(code({"5: 10 10"}, {{"region", "[0, 0, 5, 20, 3]"}}, image), "bad-region");
  EXPECT_EQ(code({"5: 10 10"}, {{"region", "[1.2, 1.2, 0.1, 0.1]"}}, image), "no-pixels");
  EXPECT_EQ(code({"5: 10 10"}, {}, Value::of(Image(48, 48, 1, 1, Vec3f::Constant(0.3f)))), "one-color");
  EXPECT_EQ(code({"5: 10 10"}, {}, Value::of(Image(48, 48, 2, 1))), "several-sections");
  EXPECT_EQ(code({"5: 10 10"}, {}, Value::of(Image())), "no-pixels");
  EXPECT_EQ(test::code_of([&] { test::run_node("TextureNib", {{"image", image}}); }), "nothing-to-paint");
  Strokes malformed;
  malformed.strokes.push_back({{{Vec2(5, std::nan(""))}}, 3, false});
  EXPECT_EQ(test::code_of([&] {
              test::run_node("TextureNib", {{"image", image}, {"strokes", Value::of(malformed)}});
            }),
            "bad-stroke");
}

}  // namespace
}  // namespace terrazzo
