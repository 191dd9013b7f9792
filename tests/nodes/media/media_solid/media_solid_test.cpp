// Solids of phases: patterns, descent, agreement with the picture, bad input.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "nodes/media/annealing/anneal.h"
#include "nodes/media/annealing/comparison.h"
#include "nodes/media/annealing/level.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace annealing;
using media::PhaseMap;

// Discs of one radius at random places; `phases` kinds of them in turn.
PhaseMap discs(int side, double radius, int count, int phases, std::uint64_t seed) {
  PhaseMap map{side, side, phases, 0.5, std::vector<std::uint8_t>(static_cast<std::size_t>(side) * side, 0)};
  for (int k = 0; k < count; ++k) {
    Random r(seed, 9, k);
    const double cx = r.uniform(0, side), cy = r.uniform(0, side);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        if (std::hypot(x - cx, y - cy) < radius)
          map.at[map.index(x, y)] = static_cast<std::uint8_t>(1 + k % (phases - 1));
  }
  return map;
}

TEST(MediaSolid, PatternFrequenciesAreThoseOfThePicture) {
  const PhaseMap map = discs(40, 5, 12, 2, 1);
  for (const int spacing : {1, 2, 4}) {
    const Frequencies upright = pattern_frequencies(map, 1, spacing, false),
                      turned = pattern_frequencies(map, 1, spacing, true);
    EXPECT_NEAR(std::accumulate(upright.begin(), upright.end(), 0.0), 1, 1e-12);
    EXPECT_NEAR(std::accumulate(turned.begin(), turned.end(), 0.0), 1, 1e-12);
    // By definition: the pattern at a place, and its complement for the other phase.
    Frequencies direct{};
    const int n = 40 - 2 * spacing;
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        int pattern = 0;
        for (int row = 0; row < 3; ++row)
          for (int column = 0; column < 3; ++column)
            pattern |= (map.at[map.index(x + column * spacing, y + (2 - row) * spacing)] == 1)
                       << (3 * column + row);
        direct[pattern] += 1.0 / (n * n);
      }
    const Frequencies other = pattern_frequencies(map, 0, spacing, false);
    for (int k = 0; k < kPatterns; ++k) {
      EXPECT_NEAR(upright[k], direct[k], 1e-12);
      EXPECT_NEAR(other[511 - k], upright[k], 1e-12);
    }
    // A lone pixel in a corner is as frequent as in any other, once turned.
    EXPECT_NEAR(turned[1], turned[4], 1e-12);
    EXPECT_NEAR(turned[1], turned[256], 1e-12);
  }
}

TEST(MediaSolid, PlacesThatAreNotObservedDoNotCount) {
  PhaseMap map = discs(40, 5, 12, 2, 1);
  const PhaseMap left{20, 40, 2, 1, [&] {
                        std::vector<std::uint8_t> at;
                        for (int y = 0; y < 40; ++y)
                          for (int x = 0; x < 20; ++x) at.push_back(map.at[map.index(x, y)]);
                        return at;
                      }()};
  for (int y = 0; y < 40; ++y)
    for (int x = 20; x < 40; ++x) map.at[map.index(x, y)] = media::kUnobserved;
  EXPECT_EQ(pattern_frequencies(map, 1, 2, true), pattern_frequencies(left, 1, 2, true));
  EXPECT_EQ(fractions_of(map), fractions_of(left));
}

// The counts that sweeps update are those of the field that they leave.
TEST(MediaSolid, CountsFollowTheField) {
  for (const int phases : {2, 3}) {
    const PhaseMap map = discs(48, 4, 30, phases, 2);
    const Vec3i size(10, 12, 9);
    std::vector<PatternTarget> targets;
    for (const int spacing : {1, 2})
      for (int axis = 0; axis < 3; ++axis) {
        targets.push_back({axis, spacing, {}});
        for (int p = 0; p < phases; ++p)
          targets.back().phase.push_back(pattern_frequencies(map, p, spacing, true));
      }
    std::vector<std::uint8_t> noise(10 * 12 * 9);
    for (std::size_t i = 0; i < noise.size(); ++i)
      noise[i] = static_cast<std::uint8_t>(Random(3, 1, i).below(phases));
    Level level(noise, size, phases, targets, 1e-3, Ends::Tile, {});
    const double before = level.mismatch();
    for (int s = 0; s < 5; ++s) EXPECT_GT(level.sweep(s, s < 3 ? 2.0 : 0.0, {}), 0u);
    const double after = level.mismatch();
    EXPECT_LT(after, before / 3);
    EXPECT_NEAR(Level(level.take(), size, phases, targets, 1e-3, Ends::Tile, {}).mismatch(), after,
                1e-9 * before);
  }
}

TEST(MediaSolid, FractionsAreExactAndFunctionsAgree) {
  for (const int phases : {2, 3}) {
    const PhaseMap map = discs(128, 6, 40, phases, 4);
    AnnealOptions options;
    options.size = {40, 48, 36};
    const Solid solid = synthesize({map}, options, {});
    const auto target = fractions_of(map);
    for (int p = 0; p < phases; ++p)
      EXPECT_NEAR(std::count(solid.phase.begin(), solid.phase.end(), p), target[p] * 40 * 48 * 36, 1) << p;
    EXPECT_LT(solid.levels.back().end, 0.2 * solid.levels.back().start);
    for (const Agreement& a : compare_slices({map}, options, solid, {})) {
      if (a.measure == "two-point correlation" || a.measure == "lineal path") {
        EXPECT_LT(a.difference, 0.04) << a.measure << a.phase;
      } else if (a.measure == "surface per volume") {
        EXPECT_NEAR(a.of_solid[0] / a.of_picture[0], 1, 0.25) << a.phase;
      }
    }
  }
}

// A picture that agrees with itself: noise, of which every slice of a solid of noise is another picture.
TEST(MediaSolid, NoiseStaysNoise) {
  PhaseMap map{96, 96, 2, 1, {}};
  for (int i = 0; i < 96 * 96; ++i) map.at.push_back(Random(5, 1, i).uniform() < 0.3);
  AnnealOptions options;
  options.size = Vec3i::Constant(32);
  const Solid solid = synthesize({map}, options, {});
  EXPECT_LT(solid.levels.back().end, 0.5 * solid.levels.back().start);
  const auto all = compare_slices({map}, options, solid, {});
  for (const Agreement& a : all)
    for (std::size_t r = 1; a.measure == "two-point correlation" && a.phase == 1 && r < a.of_solid.size();
         ++r)
      EXPECT_NEAR(a.of_solid[r], 0.09, 0.02) << r;
}

// Stripes along the picture's columns stay along z on both planes that show them.
TEST(MediaSolid, ADirectionalPictureStaysUpright) {
  PhaseMap map{64, 64, 2, 1, {}};
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) map.at.push_back(Random(7, 1, x / 3).uniform() < 0.5);
  Labels labels = labels_of(map);
  const auto run = test::run_node("MediaSolid", {{"labels", Value::of(labels)}}, {{"size", "24"}});
  ASSERT_EQ(run.warnings.size(), 2u);  // directional, and few structures
  EXPECT_NE(run.warnings[0].find("directional"), std::string::npos);
  const auto phase = run.output<Volume>("volume").find<openvdb::Int32Grid>("phase");
  ASSERT_TRUE(phase);
  int along = 0, across = 0;
  for (int z = 0; z + 1 < 24; ++z)
    for (int y = 0; y + 1 < 24; ++y)
      for (int x = 0; x + 1 < 24; ++x) {
        const int v = phase->tree().getValue({x, y, z});
        along += v != phase->tree().getValue({x, y, z + 1});
        across += v != phase->tree().getValue({x + 1, y, z});
      }
  EXPECT_LT(along, across / 3);
}

// Phase 1 is in stripes of 3 pixels along rows or along columns.
PhaseMap stripes(bool along_rows) {
  PhaseMap map{48, 48, 2, 1, {}};
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 48; ++x) map.at.push_back((along_rows ? y : x) / 3 % 2);
  return map;
}

// Layers across z: rows of the pictures across x and y, and a plain third one. The same layers across y are
// columns of the first picture and rows of the third.
TEST(MediaSolid, ThreePicturesLieAsDocumented) {
  const auto labels = [](const PhaseMap& map) { return Value::of(labels_of(map)); };
  PhaseMap mixed = discs(48, 12, 3, 2, 1);
  mixed.pixel_size = 1;
  const auto changes = [](const test::NodeRun& run) {
    const auto grid = run.output<Volume>("volume").find<openvdb::Int32Grid>("phase");
    std::array<int, 3> out{};
    for (int x = 0; x < 23; ++x)
      for (int y = 0; y < 23; ++y)
        for (int z = 0; z < 23; ++z) {
          const int v = grid->tree().getValue({x, y, z});
          out[0] += v != grid->tree().getValue({x + 1, y, z});
          out[1] += v != grid->tree().getValue({x, y + 1, z});
          out[2] += v != grid->tree().getValue({x, y, z + 1});
        }
    return out;
  };
  const auto across_z = changes(test::run_node(
      "MediaSolid",
      {{"labels", labels(stripes(true))}, {"labels", labels(stripes(true))}, {"labels", labels(mixed)}},
      {{"size", "24"}, {"planes", "[x, y, z]"}}));
  EXPECT_GT(across_z[2], 2 * across_z[0]);
  EXPECT_GT(across_z[2], 2 * across_z[1]);
  const auto across_y = changes(test::run_node(
      "MediaSolid",
      {{"labels", labels(stripes(false))}, {"labels", labels(mixed)}, {"labels", labels(stripes(true))}},
      {{"size", "24"}, {"planes", "[x, y, z]"}}));
  EXPECT_GT(across_y[1], 2 * across_y[0]);
  EXPECT_GT(across_y[1], 2 * across_y[2]);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("MediaSolid", {{"labels", labels(mixed)}, {"labels", labels(mixed)}},
                             {{"size", "16"}, {"planes", "[x, y]"}});
            }),
            "bad-value");
}

TEST(MediaSolid, MaskedPixelsDoNotCount) {
  PhaseMap map = discs(64, 5, 25, 2, 3);
  Labels mask = labels_of(map), spoiled = labels_of(map);
  for (int i = 0; i < 64 * 64; ++i) {
    mask.ids[i] = i / 64 >= 48;
    if (mask.ids[i]) spoiled.ids[i] = 1;
  }
  const auto run = test::run_node("MediaSolid", {{"labels", Value::of(spoiled)}, {"masks", Value::of(mask)}},
                                  {{"size", "24"}});
  const auto grid = run.output<Volume>("volume").find<openvdb::Int32Grid>("phase");
  double ones = 0, expected = 0;
  for (int x = 0; x < 24; ++x)
    for (int y = 0; y < 24; ++y)
      for (int z = 0; z < 24; ++z) ones += grid->tree().getValue({x, y, z});
  for (int i = 0; i < 64 * 48; ++i) expected += map.at[i] / (64.0 * 48);
  EXPECT_NEAR(ones, expected * 24 * 24 * 24, 1);
  mask.ids.assign(mask.ids.size(), 1);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("MediaSolid", {{"labels", Value::of(spoiled)}, {"masks", Value::of(mask)}},
                             {{"size", "16"}});
            }),
            "one-phase");
}

TEST(MediaSolid, EqualForAnyNumberOfThreads) {
  const Labels labels = labels_of(discs(64, 5, 20, 3, 8));
  std::vector<std::vector<int>> found;
  for (const int threads : {1, 2, 7}) {
    const auto run = test::run_node("MediaSolid", {{"labels", Value::of(labels)}}, {{"size", "[48, 40, 44]"}},
                                    {}, threads);
    const auto grid = run.output<Volume>("volume").find<openvdb::Int32Grid>("phase");
    found.emplace_back();
    for (int x = 0; x < 48; ++x)
      for (int y = 0; y < 40; ++y)
        for (int z = 0; z < 44; ++z) found.back().push_back(grid->tree().getValue({x, y, z}));
  }
  EXPECT_EQ(found[0], found[1]);
  EXPECT_EQ(found[0], found[2]);
}

TEST(MediaSolid, AnImageBesideLabelsGivesTheColors) {
  const PhaseMap map = discs(48, 5, 12, 2, 1);
  Image image(48, 48, 1, 1);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 48; ++x)
      image.at(x, y) = map.at[map.index(x, y)] == 0 ? Vec3f(0.1f, 0.2f, 0.3f) : Vec3f(0.8f, 0.4f, 0.2f);
  const auto run = test::run_node(
      "MediaSolid", {{"labels", Value::of(labels_of(map))}, {"image", Value::of(image)}}, {{"size", "16"}});
  const Volume& volume = run.output<Volume>("volume");
  const auto phase = volume.find<openvdb::Int32Grid>("phase");
  const auto color = volume.find<openvdb::Vec3SGrid>("Cd");
  ASSERT_TRUE(color);
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y) {
      const bool dark = phase->tree().getValue({x, y, 0}) == 0;
      const auto c = color->tree().getValue({x, y, 0});
      EXPECT_NEAR(c.x(), dark ? 0.1 : 0.8, 2e-3);
      EXPECT_NEAR(c.z(), dark ? 0.3 : 0.2, 2e-3);
    }
}

TEST(MediaSolid, BadPicturesAreErrors) {
  const auto code = [](const std::multimap<std::string, Value>& inputs) {
    return test::code_of([&] { test::run_node("MediaSolid", inputs, {{"size", "16"}}); });
  };
  const auto labels = [](const PhaseMap& map) { return Value::of(labels_of(map)); };
  const PhaseMap good = discs(48, 5, 12, 2, 1);
  EXPECT_EQ(code({}), "missing-input");
  EXPECT_EQ(code({{"labels", labels(good)}, {"image", Value::of(Image(48, 40, 1, 1))}}), "size-mismatch");
  EXPECT_EQ(code({{"labels", labels(good)},
                  {"image", Value::of(Image(48, 48, 1, 1))},
                  {"image", Value::of(Image(48, 48, 1, 1))}}),
            "too-many-inputs");
  EXPECT_EQ(code({{"labels", labels(discs(24, 4, 9, 2, 1))}}), "exemplar-too-small");
  EXPECT_EQ(code({{"labels", labels(PhaseMap{40, 40, 2, 1, std::vector<std::uint8_t>(1600, 1)})}}),
            "one-phase");
  PhaseMap scaled = good;
  scaled.pixel_size = 0.7;
  EXPECT_EQ(code({{"labels", labels(good)}, {"labels", labels(scaled)}}), "size-mismatch");
  EXPECT_EQ(code({{"labels", labels(good)}, {"labels", labels(discs(48, 5, 12, 3, 1))}}), "phases-differ");
  EXPECT_EQ(code({{"labels", labels(good)},
                  {"labels", labels(good)},
                  {"labels", labels(good)},
                  {"labels", labels(good)}}),
            "too-many-inputs");
  Labels many = labels_of(good);
  many.classes = {40};
  EXPECT_EQ(code({{"labels", Value::of(many)}}), "too-many-phases");
}

// Real micrographs: the functions of slices are within what parts of the picture differ by.
TEST(MediaSolid, MicrographsAreMetWithinTheirScatter) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  for (const char* name : {"ceramics", "sandstone"}) {
    const auto image = test::run_node("LoadImage", {}, {{"path", (data / "media" / name).string() + ".png"}});
    const auto run =
        test::run_node("MediaSolid", {{"image", Value::of(image.output<Image>("image"))}}, {{"size", "32"}});
    const Table& t = run.output<Table>("table");
    for (std::size_t row = 0; row < t.rows.size(); ++row)
      if (const auto& m = std::get<std::string>(t.rows[row][2]);
          m == "two-point correlation" || m == "lineal path") {
        EXPECT_LT(t.number(row, "difference"), 2 * t.number(row, "scatter")) << name << " " << m;
      }
    EXPECT_LT(run.metrics.at("surface"), 0.1) << name;
  }
}

}  // namespace
}  // namespace terrazzo
