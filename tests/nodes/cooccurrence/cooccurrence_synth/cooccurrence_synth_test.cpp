#include <gtest/gtest.h>

#include <map>
#include <set>

#include "nodes/common/io/image_file.h"
#include "nodes/common/texture/color_levels.h"
#include "nodes/common/texture/cooccurrence.h"
#include "nodes/data/labels.h"
#include "nodes/data/table.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

Image pattern(const char* kind, int size, const char* axis = "z") {
  return test::run_node("Pattern", {},
                        {{"kind", kind},
                         {"axis", axis},
                         {"width", std::to_string(size)},
                         {"height", std::to_string(size)}})
      .output<Image>("image");
}

std::set<std::tuple<float, float, float>> colors(const Image& image) {
  std::set<std::tuple<float, float, float>> out;
  for (const auto& p : image.pixels) out.emplace(p.x(), p.y(), p.z());
  return out;
}

TEST(CooccurrenceSynth, MatchesThePicturesMatrix) {
  const Image source = pattern("fat", 96);
  for (const char* start : {"noise", "coarse"})
    for (const char* tileable : {"true", "false"}) {
      const auto r = test::run_node("CooccurrenceSynth", {{"image", Value::of(source)}},
                                    {{"tileable", tileable}, {"start", start}});
      const Table& t = r.output<Table>("table");
      EXPECT_EQ(t.columns, (std::vector<std::string>{"stride", "sweep", "error", "changed"}));
      EXPECT_EQ(t.number(0, "stride"), start[0] == 'n' ? 1 : 8);
      EXPECT_EQ(t.number(t.rows.size() - 1, "stride"), 1);
      for (std::size_t i = 1; i < t.rows.size(); ++i)
        if (t.number(i, "sweep") > 0)
          EXPECT_LE(t.number(i, "error"), t.number(i - 1, "error"));
        else
          EXPECT_EQ(t.number(i, "stride"), t.number(i - 1, "stride") / 2);
      EXPECT_LT(t.number(t.rows.size() - 1, "error"), r.metrics.at("error_start") / 300);
      EXPECT_EQ(colors(r.output<Image>("image")), colors(r.output<Image>("quantized")));
      EXPECT_LT(r.metrics.at("histogram_distance"), 0.02);
    }
}

// A field of wood made from noise ends in a lattice of spots, whose error a sweep cannot reduce. Made from
// coarse to fine, its fibers are continuous.
TEST(CooccurrenceSynth, LongStructuresNeedACoarseStart) {
  const Value wood = Value::of(pattern("wood", 128, "x"));
  const auto ratio = [&](const char* start) {
    const auto r = test::run_node("CooccurrenceSynth", {{"image", wood}}, {{"start", start}});
    return r.metrics.at("error_start") / r.metrics.at("error");
  };
  EXPECT_GT(ratio("coarse"), 1000);
  EXPECT_LT(ratio("noise"), 1000);
}

// A striped mask has no pairs at longer offsets, so its field starts at a scale that has some.
TEST(CooccurrenceSynth, StartsNoCoarserThanTheSourceTells) {
  const Image source = pattern("fat", 64);
  Image stripes(64, 64, 1, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      if (x % 16 < 3) stripes.at(x, y) = Vec3f::Ones();
  const auto r =
      test::run_node("CooccurrenceSynth", {{"image", Value::of(source)}, {"mask", Value::of(stripes)}});
  EXPECT_EQ(r.output<Table>("table").number(0, "stride"), 1);
}

TEST(CooccurrenceSynth, SizeSeedAndSpace) {
  const Value source = Value::of(pattern("marble", 48));
  const auto run = [&](std::map<std::string, std::string> p) {
    return test::run_node("CooccurrenceSynth", {{"image", source}}, p).output<Image>("image");
  };
  const Image a = run({{"size", "[40, 24]"}}), b = run({{"size", "[40, 24]"}}),
              c = run({{"size", "[40, 24]"}, {"seed", "2"}});
  EXPECT_EQ(a.width, 40);
  EXPECT_EQ(a.height, 24);
  EXPECT_EQ(a.pixels, b.pixels);
  EXPECT_NE(a.pixels, c.pixels);
  EXPECT_EQ(run({{"size", "20"}}).height, 20);
  EXPECT_LE(colors(run({{"space", "rgb"}, {"levels", "3"}})).size(), 3u);
}

// With patches every color is the picture's own, more neighbors are those of the picture, and the matrix is
// still close.
TEST(CooccurrenceSynth, PatchesKeepWhatLiesSideBySide) {
  const Image source = pattern("fat", 128);
  std::map<std::tuple<float, float, float>, std::size_t> where;
  for (std::size_t i = 0; i < source.pixels.size(); ++i)
    where[{source.pixels[i].x(), source.pixels[i].y(), source.pixels[i].z()}] = i;
  for (const char* tileable : {"true", "false"}) {
    const auto r = test::run_node("CooccurrenceSynth", {{"image", Value::of(source)}},
                                  {{"finish", "patches"}, {"size", "[96, 80]"}, {"tileable", tileable}});
    const Image& got = r.output<Image>("image");
    std::size_t together = 0;
    const auto number = [&](int x, int y) {
      const Vec3f& c = got.at(x, y);
      const auto it = where.find({c.x(), c.y(), c.z()});
      EXPECT_NE(it, where.end());
      return it == where.end() ? source.pixels.size() : it->second;
    };
    for (int y = 0; y < got.height; ++y)
      for (int x = 0; x + 1 < got.width; ++x) together += number(x + 1, y) == number(x, y) + 1;
    EXPECT_GT(together, 95u * 80 / 4);
    EXPECT_LT(r.metrics.at("finished_error"), r.metrics.at("error_start") / 8);
  }
}

TEST(CooccurrenceSynth, MeasuresUnderTheMaskAlone) {
  Image source(40, 40, 1, 1);
  Labels mask;
  mask.width = mask.height = 40;
  mask.ids.assign(1600, 0);
  mask.classes = {0};
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      source.at(x, y) =
          x < 20 ? Vec3f::Constant(Random(1, 0, y * 40 + x).below(2) ? 0.2f : 0.6f) : Vec3f(1, 0, 0);
      mask.ids[static_cast<std::size_t>(y * 40 + x)] = x < 20;
    }
  const auto r =
      test::run_node("CooccurrenceSynth", {{"image", Value::of(source)}, {"mask", Value::of(mask)}});
  for (const auto& p : r.output<Image>("image").pixels) EXPECT_NEAR(p.x(), p.y(), 1e-3);
}

TEST(CooccurrenceSynth, RefusesWhatItCannotMeasure) {
  const Value good = Value::of(pattern("fat", 32));
  const auto code = [&](const Value& image, std::map<std::string, std::string> p,
                        std::multimap<std::string, Value> more = {}) {
    more.emplace("image", image);
    return test::code_of([&] { test::run_node("CooccurrenceSynth", more, p); });
  };
  EXPECT_EQ(code(Value::of(Image(32, 32, 1, 1, Vec3f::Constant(0.5f))), {}), "one-color");
  EXPECT_EQ(code(good, {{"extent", "8"}, {"scales", "3"}}), "too-small");
  EXPECT_EQ(code(good, {{"extent", "8"}, {"size", "8"}}), "too-small");
  EXPECT_EQ(code(Value::of(Image()), {}), "no-pixels");
  Image bad(32, 32, 1, 1);
  bad.pixels[5].x() = std::nanf("");
  EXPECT_EQ(code(Value::of(bad), {}), "bad-pixels");
  EXPECT_EQ(code(good, {}, {{"mask", Value::of(Image(16, 16, 1, 1))}}), "wrong-size");
  EXPECT_EQ(code(good, {}, {{"mask", Value::of(Image(32, 32, 1, 1))}}), "no-pixels");
  Image thin(32, 32, 1, 1);  // a mask of single columns: no two of its pixels are side by side
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; x += 8) thin.at(x, y) = Vec3f::Ones();
  EXPECT_EQ(code(good, {}, {{"mask", Value::of(thin)}}), "no-pairs");
}

TEST(CooccurrenceSynth, Photographs) {
  const auto folder = test::shared_data();
  if (folder.empty()) GTEST_SKIP() << "the shared pictures are not available";
  Image photo = read_image(folder / "photos" / "gravel.png");
  Image part(96, 96, 1, 1);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x) part.at(x, y) = photo.at(x + 100, y + 100);
  const auto r = test::run_node("CooccurrenceSynth", {{"image", Value::of(part)}});
  EXPECT_LT(r.metrics.at("error"), r.metrics.at("error_start") / 1000);
}

}  // namespace
}  // namespace terrazzo
