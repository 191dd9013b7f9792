// Families of shapes compared on sections of packings whose particles have one of them.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "nodes/sizes/shape_families/likeness.h"
#include "nodes/sizes/shape_families/score.h"
#include "nodes/sizes/shape_families/sections.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape_families;
using test::code_of;

using Parameters = std::map<std::string, std::string>;

struct Known {
  Value shapes, kmatrix;
  Family family(const std::string& name) const {
    return {name, &shapes.as<Shapes>(), &kmatrix.as<KMatrix>()};
  }
};

Known known(const std::string& kind, Parameters more = {}) {
  more["kind"] = kind, more["size"] = "1";
  Known k;
  k.shapes = test::run_node("Shape", {}, more).outputs.at("shapes");
  k.kmatrix =
      test::run_node("KMatrix", {{"shapes", k.shapes}}, {{"orientations", "400"}}).outputs.at("kmatrix");
  return k;
}

// Profiles of particles of sizes 1 to 3 mm in planes through boxes of random, overlapping particles, which is
// all that unfolding assumes. N_V is the number of particles per mm³.
Profiles cut(const Shapes& shapes, double n_v, double area, std::uint64_t seed) {
  const double lo = 1, hi = 3, unit = shapes.shapes[0].mean_caliper / shapes.shapes[0].size();
  Profiles p;
  p.observed_area = area;
  Random random(seed, 77);
  // Planes hit particles of size D in proportion to their caliper diameter: N_A = N_V · unit · mean size.
  const auto n = static_cast<std::size_t>(n_v * unit * (lo + hi) / 2 * area);
  std::vector<double> sizes;
  while (sizes.size() < n)
    if (const double d = random.uniform(lo, hi); random.uniform(0, hi) < d) sizes.push_back(d);
  Shapes one = shapes;
  for (std::size_t i = 0; i < n; ++i) {
    const auto section = random_sections(one, 1, {.seed = seed, .first = i});
    for (const auto& loops : section[0]) {
      Profile q;
      const double scale = sizes[i] / shapes.shapes[0].size();
      for (const Vec2& v : loops.front()) q.contour.push_back(v * scale);
      q.area = loop_area(q.contour);
      p.area_fraction += q.area / area;
      p.profiles.push_back(std::move(q));
    }
  }
  return p;
}

ScoreOptions quick() {
  ScoreOptions s;
  s.sections = 800;
  s.bootstrap = 0;
  return s;
}

// Whatever the true family is, it predicts best, and its N_V is right while others are off.
TEST(ShapeFamilies, TheTrueFamilyPredictsBest) {
  const Known sphere = known("sphere", {{"detail", "2"}}), box = known("box", {{"axes", "[1, 1, 1]"}}),
              octahedron = known("octahedron"), slab = known("box", {{"axes", "[2, 1, 0.5]"}});
  const std::vector<Family> families = {sphere.family("sphere"), box.family("box"),
                                        octahedron.family("octahedron"), slab.family("slab")};
  for (std::size_t truth = 0; truth < families.size(); ++truth) {
    const Profiles p = cut(*families[truth].shapes, 0.02, 10000, 1 + truth);
    ScoreOptions settings = quick();
    settings.folds = 3;
    const Scores s = score_families(p, families, settings, {});
    EXPECT_EQ(s.best, truth) << families[s.best].name << " for " << families[truth].name;
    EXPECT_NEAR(s.families[truth].N_V / 0.02, 1, 0.25) << families[truth].name;
    EXPECT_EQ(s.families[truth].behind, 0);
    for (std::size_t f = 0; f < families.size(); ++f)
      if (f != truth) {
        EXPECT_LT(s.families[f].behind, 0) << families[f].name;
        EXPECT_FALSE(s.families[f].plausible) << families[f].name << " for " << families[truth].name;
      }
  }
}

// Lists of areas have no outlines: sizes alone hardly tell convex shapes apart, and the node says so.
TEST(ShapeFamilies, SizesAloneDecideLittle) {
  const Known sphere = known("sphere", {{"detail", "2"}}), octahedron = known("octahedron");
  Profiles p = cut(octahedron.shapes.as<Shapes>(), 0.02, 8000, 3);
  for (Profile& q : p.profiles) q.contour.clear();
  const auto compared = [&] {
    return test::run_node("ShapeFamilies",
                          {{"profiles", Value::of(p)},
                           {"shapes", sphere.shapes},
                           {"shapes", octahedron.shapes},
                           {"kmatrices", sphere.kmatrix},
                           {"kmatrices", octahedron.kmatrix}},
                          {{"bootstrap", "0"}, {"sections", "200"}, {"names", "[sphere, octahedron]"}});
  };
  const auto r = compared();
  EXPECT_EQ(r.output<Table>("table").column("N_V mm⁻³"), 6);
  EXPECT_EQ(r.metrics.count("N_V"), 1u);
  EXPECT_EQ(r.metrics.at("outlines"), 0);
  const auto& table = r.output<Table>("table");
  EXPECT_LT(std::abs(table.number(0, "sizes") - table.number(1, "sizes")), 0.05);
  EXPECT_EQ(table.number(0, "outlines"), 0);
  EXPECT_FALSE(r.warnings.empty());
  // Without an area, densities have no unit.
  p.observed_area = 0;
  p.area_fraction = 0;
  const auto relative = compared();
  EXPECT_EQ(relative.output<Table>("table").column("N_V relative"), 6);
  EXPECT_EQ(relative.metrics.count("N_V"), 0u);
}

// A family twice in the list: equal predictions, both plausible, no disagreement.
TEST(ShapeFamilies, EqualFamiliesAreEqual) {
  const Known box = known("box", {{"axes", "[1, 1, 1]"}});
  const Profiles p = cut(box.shapes.as<Shapes>(), 0.02, 5000, 5);
  const Scores s = score_families(p, {box.family("a"), box.family("b")}, quick(), {});
  EXPECT_EQ(s.families[1].behind, 0);
  EXPECT_EQ(s.families[1].error, 0);
  EXPECT_TRUE(s.families[1].plausible);
  EXPECT_EQ(s.families[0].N_V, s.families[1].N_V);
}

// Outlines that follow pixels are blurred according to their resolution, and coarse ones are left out.
TEST(ShapeFamilies, OutlinesAreMeasuredAtTheirResolution) {
  const auto disc = [](double radius) {  // points at steps of a pixel, scattered by a tenth
    Profile p;
    Random random(3);
    const int n = static_cast<int>(2 * std::numbers::pi * radius);
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n, r = radius + random.uniform(-0.1, 0.1);
      p.contour.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    return p;
  };
  EXPECT_FALSE(measured(disc(3)).has_value());
  const auto coarse = measured(disc(8)), fine = measured(disc(60));
  ASSERT_TRUE(coarse && fine);
  EXPECT_GT(coarse->level, fine->level);
  EXPECT_NEAR(coarse->features[0], 1, 0.05);
  EXPECT_NEAR(fine->features[0], 1, 0.02);
  EXPECT_NEAR(fine->features[1], 1, 0.02);
  Profile at_border = disc(60);
  at_border.touches_border = true;
  EXPECT_FALSE(measured(at_border).has_value());
}

// Probabilities of shapes at any size of particles sum to 1, and favor shapes of that size.
TEST(ShapeFamilies, ParticlesHaveShapesOfTheirSize) {
  const Shapes ball = known("sphere", {{"detail", "1"}}).shapes.as<Shapes>();
  Shapes many;
  Random random(9);
  double mean = 0;
  for (int i = 0; i < 40; ++i) {
    Shape s = ball.shapes[0];
    const double scale = random.uniform(0.3, 2);
    for (Vec3& v : s.mesh.vertices) v *= scale;
    s.max_section_area *= scale * scale;
    s.mean_caliper *= scale;
    s.probability = 1.0 / 40;
    mean += s.size() / 40;
    many.shapes.push_back(s);
  }
  const Likeness likeness(many), equal(ball);
  for (const double size : {0.01, 0.3, 0.7, 1.0, 1.4, 3.0}) {
    double sum = 0;
    for (const Shape& s : many.shapes) sum += likeness(s.size() / mean, size) / 40;
    EXPECT_NEAR(sum, 1, 0.02) << size;
    EXPECT_EQ(equal(1, size), 1);
  }
  EXPECT_GT(likeness(1.5, 1.5), 3 * likeness(0.7, 1.5));
}

// Sections of a mixture have the shapes' shares, and all are scaled to size 1.
TEST(ShapeFamilies, SectionsOfAFamilyHaveSizeOne) {
  Shapes two = known("sphere", {{"detail", "3"}}).shapes.as<Shapes>();
  two.shapes.push_back(two.shapes[0]);
  two.shapes[0].probability = 0.25;
  two.shapes[1].probability = 0.75;
  for (Vec3& v : two.shapes[1].mesh.vertices) v *= 4;
  two.shapes[1].max_section_area *= 16;
  two.shapes[1].mean_caliper *= 4;
  const FamilySections s = family_sections(two, 2000, 1, {});
  ASSERT_EQ(s.ratio.size(), 2000u);
  double squares = 0;
  std::size_t large = 0;
  for (std::size_t i = 0; i < s.ratio.size(); ++i) {
    EXPECT_LE(s.ratio[i], 1.001);
    squares += s.ratio[i] * s.ratio[i];
    large += s.natural[i] > 1;
  }
  EXPECT_NEAR(squares / 2000, 2.0 / 3, 0.02);  // of spheres, E[A] = 2/3 A_max
  EXPECT_NEAR(static_cast<double>(large), 1500, 1);
}

TEST(ShapeFamilies, SaysWhatIsWrong) {
  const Known box = known("box", {{"axes", "[1, 1, 1]"}}), ball = known("sphere", {{"detail", "1"}});
  const Profiles p = cut(box.shapes.as<Shapes>(), 0.02, 800, 5);
  const auto run = [&](const Profiles& profiles, std::vector<Value> shapes, std::vector<Value> matrices,
                       Parameters parameters = {}) {
    std::multimap<std::string, Value> inputs = {{"profiles", Value::of(profiles)}};
    for (const Value& v : shapes) inputs.emplace("shapes", v);
    for (const Value& v : matrices) inputs.emplace("kmatrices", v);
    return code_of([&] { test::run_node("ShapeFamilies", inputs, parameters); });
  };
  EXPECT_EQ(run(p, {box.shapes, ball.shapes}, {box.kmatrix}), "wrong-count");
  EXPECT_EQ(run(p, {box.shapes}, {box.kmatrix}, {{"names", "[a, b]"}}), "wrong-count");
  EXPECT_EQ(run(p, {box.shapes}, {box.kmatrix}, {{"folds", "20"}}), "too-few-profiles");
  Shapes two = box.shapes.as<Shapes>();
  two.shapes.push_back(two.shapes[0]);
  EXPECT_EQ(run(p, {Value::of(two)}, {box.kmatrix}), "wrong-count");
  EXPECT_EQ(run({}, {box.shapes}, {box.kmatrix}), "no-profiles");
}

}  // namespace
}  // namespace terrazzo
