// Closed forms of measures, percentiles, mean intercepts and grain size numbers.
#include "nodes/sizes/grain_size/grain_size.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/common/stereology/outline_measures.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace grain_size;
using std::numbers::pi;

// Half axes a and b, turned by `degrees` counterclockwise.
Loop ellipse(double a, double b, double degrees, const Vec2& center = Vec2::Zero()) {
  Loop out;
  const Eigen::Rotation2Dd turn(degrees * pi / 180);
  constexpr int kPoints = 2000;
  for (int i = 0; i < kPoints; ++i)
    out.push_back(center +
                  turn * Vec2(a * std::cos(2 * pi * i / kPoints), b * std::sin(2 * pi * i / kPoints)));
  return out;
}

Profiles profiles_of(const std::vector<Loop>& loops, double weight = 1) {
  Profiles out;
  for (const Loop& loop : loops) {
    Profile p;
    p.area = loop_area(loop);
    p.contour = loop;
    p.weight = weight;
    out.profiles.push_back(p);
  }
  return out;
}

Sizes sizes_by(const Profiles& profiles, Diameter diameter) {
  return sizes_of(profiles, profile_columns(profiles), diameter);
}

Measure measure_of(const std::vector<Measure>& measures, const std::string& name) {
  for (const Measure& m : measures)
    if (m.name == name) return m;
  ADD_FAILURE() << name;
  return {};
}
double value_of(const std::vector<Measure>& measures, const std::string& name) {
  return measure_of(measures, name).value;
}

TEST(GrainSizeMeasures, OfAnEllipse) {
  for (const double degrees : {0.0, 30.0, 135.0, 179.0}) {
    const OutlineMeasures m = outline_measures(ellipse(3, 2, degrees));
    EXPECT_NEAR(m.major_axis, 6, 1e-4);
    EXPECT_NEAR(m.minor_axis, 4, 1e-4);
    EXPECT_NEAR(std::remainder(m.orientation - degrees, 180), 0, 1e-6);
    EXPECT_NEAR(m.feret_max, 6, 1e-4);
    EXPECT_NEAR(m.feret_min, 4, 1e-4);
    EXPECT_NEAR(m.perimeter, 15.8654396, 1e-4);  // 4a E(e)
    EXPECT_NEAR(m.circularity, 4 * pi * 6 * pi / (15.8654396 * 15.8654396), 1e-4);
    EXPECT_NEAR(m.solidity, 1, 1e-9);
  }
  const OutlineMeasures disc = outline_measures(ellipse(1, 1, 0));
  EXPECT_NEAR(disc.major_axis, 2, 1e-4);
  EXPECT_NEAR(disc.circularity, 1, 1e-4);
}

TEST(GrainSizeMeasures, OfRectanglesAndAnAngle) {
  const OutlineMeasures m = outline_measures({{1, 1}, {7, 1}, {7, 3}, {1, 3}});
  EXPECT_NEAR(m.major_axis, 4 * 6 / std::sqrt(12), 1e-12);
  EXPECT_NEAR(m.minor_axis, 4 * 2 / std::sqrt(12), 1e-12);
  EXPECT_EQ(m.orientation, 0);
  EXPECT_NEAR(m.feret_max, std::sqrt(40.0), 1e-12);
  EXPECT_NEAR(m.feret_min, 2, 1e-12);
  EXPECT_EQ(m.perimeter, 16);
  EXPECT_EQ(outline_measures({{0, 0}, {2, 0}, {2, 6}, {0, 6}}).orientation, 90);
  // An L of three unit squares: its hull misses half a square.
  EXPECT_NEAR(outline_measures({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}).solidity, 3 / 3.5, 1e-12);
  EXPECT_EQ(outline_measures({{0, 0}, {1, 0}}).perimeter, 0);
}

TEST(GrainSize, PercentilesAreHazens) {
  Profiles profiles;
  for (const int k : {3, 1, 10, 2, 9, 4, 8, 5, 7, 6}) {
    Profile p;
    p.area = pi / 4 * k * k;
    profiles.profiles.push_back(p);
  }
  profiles.profiles.push_back(profiles.profiles[0]);
  profiles.profiles.back().weight = 0;  // at the border
  const auto m = measures_of(sizes_by(profiles, Diameter::Equivalent), 50, 1);
  EXPECT_NEAR(value_of(m, "D10 by number"), 1.5, 1e-12);
  EXPECT_NEAR(value_of(m, "D16 by number"), 2.1, 1e-12);
  EXPECT_NEAR(value_of(m, "D50 by number"), 5.5, 1e-12);
  EXPECT_NEAR(value_of(m, "D84 by number"), 8.9, 1e-12);
  EXPECT_NEAR(value_of(m, "mean by number"), 5.5, 1e-12);
  EXPECT_NEAR(value_of(m, "mean by area"), 3025.0 / 385, 1e-12);
  EXPECT_NEAR(value_of(m, "mean by weight"), 25333.0 / 3025, 1e-12);
  EXPECT_NEAR(value_of(m, "geometric mean by number"), std::pow(3628800.0, 0.1), 1e-12);
  // Squares below 8 add up to 140 of 385, and half of 8's 64 to 172; 9 begins at 204 and its middle is 244.5.
  EXPECT_NEAR(value_of(m, "D50 by area"), 8 + (192.5 - 172) / (244.5 - 172), 1e-12);
}

// The 90 % interval of a mean is ±1.645 σ/√n.
TEST(GrainSize, IntervalsAreThoseOfTheMean) {
  Profiles profiles;
  double sum = 0, square = 0;
  constexpr int kCount = 400;
  for (int i = 0; i < kCount; ++i) {
    Random random(5, 0, i);
    const double size = std::exp(0.5 * random.normal());
    sum += size;
    square += size * size;
    Profile p;
    p.area = pi / 4 * size * size;
    profiles.profiles.push_back(p);
  }
  const auto measures = measures_of(sizes_by(profiles, Diameter::Equivalent), 2000, 3);
  const double sd = std::sqrt(square / kCount - sum * sum / kCount / kCount);
  const Measure mean = measure_of(measures, "mean by number");
  EXPECT_NEAR(mean.high - mean.low, 2 * 1.645 * sd / std::sqrt(kCount), 0.1 * (mean.high - mean.low));
  EXPECT_EQ(measures[2].low, measures_of(sizes_by(profiles, Diameter::Equivalent), 2000, 3)[2].low);
  EXPECT_NE(measures[2].low, measures_of(sizes_by(profiles, Diameter::Equivalent), 2000, 4)[2].low);
}

// The part of a polygon that is nearer to a than to b.
Loop nearer_to(const Loop& loop, const Vec2& a, const Vec2& b) {
  Loop out;
  const Vec2 d = b - a;
  const auto height = [&](const Vec2& p) { return d.dot(p - (a + b) / 2); };
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &p = loop[i], &q = loop[(i + 1) % loop.size()];
    const double u = height(p), v = height(q);
    if (u <= 0) out.push_back(p);
    if ((u < 0 && v > 0) || (u > 0 && v < 0)) out.push_back(p + (q - p) * (u / (u - v)));
  }
  return out;
}

// Lines cross the cells of a plane Poisson–Voronoi tessellation of `density` in chords of mean length
// π / (4 √density) (Møller 1994). Steps of pixels do not change that.
TEST(GrainSize, MeanInterceptsOfTessellations) {
  constexpr int kCells = 3000;
  std::vector<Vec2> points;
  for (int i = 0; i < kCells; ++i) {
    Random random(7, 0, i);
    points.emplace_back(random.uniform(), random.uniform());
  }
  std::vector<Loop> cells;
  for (const Vec2& p : points) {
    Loop cell = {p + Vec2(-0.1, -0.1), p + Vec2(0.1, -0.1), p + Vec2(0.1, 0.1), p + Vec2(-0.1, 0.1)};
    for (const Vec2& other : points) {
      Vec2 d = other - p;
      d -= d.array().round().matrix();  // periodic
      if (d.squaredNorm() > 0 && d.norm() < 0.2) cell = nearer_to(cell, p, p + d);
    }
    cells.push_back(cell);
  }
  Loop stairs;  // of a disc of radius 1: lines cross it in π / 2
  for (int i = 0; i < 400; ++i) {
    const double angle = 2 * pi * i / 400, next = 2 * pi * (i + 1) / 400;
    stairs.emplace_back(std::cos(angle), std::sin(angle));
    stairs.emplace_back(std::cos(angle), std::sin(next));
  }
  const auto disc = measures_of(sizes_by(profiles_of({stairs}), Diameter::Equivalent), 20, 1);
  EXPECT_NEAR(value_of(disc, "mean intercept"), pi / 2, 1e-3);

  const auto m = measures_of(sizes_by(profiles_of(cells), Diameter::Equivalent), 20, 1);
  const double intercept = pi / (4 * std::sqrt(kCells));
  EXPECT_NEAR(value_of(m, "mean intercept"), intercept, 0.01 * intercept);
  EXPECT_NEAR(value_of(m, "mean intercept along x"), intercept, 0.02 * intercept);
  EXPECT_NEAR(value_of(m, "ASTM grain size number by intercepts"), -6.643856 * std::log10(intercept) - 3.288,
              0.03);
  // N_A = 3000 per mm².
  EXPECT_NEAR(value_of(m, "ASTM grain size number by area"), 3.321928 * std::log10(3000.0) - 2.954, 1e-9);

  const auto s =
      measures_of(sizes_by(profiles_of({{{0, 0}, {2, 0}, {2, 2}, {0, 2}}, {{2, 0}, {4, 0}, {4, 2}, {2, 2}}}),
                           Diameter::FeretMin),
                  20, 1);
  EXPECT_NEAR(value_of(s, "mean intercept"), 2, 1e-12);
  EXPECT_NEAR(value_of(s, "mean intercept along x"), 2, 1e-12);
  EXPECT_NEAR(value_of(s, "D50 by number"), 2, 1e-12);
}

// Exponential densities, whose logarithm is a line of slope −1 / (growth rate × residence time).
TEST(GrainSize, SlopeOfTheCrystalSizeDistribution) {
  SizeDistribution d;
  for (int k = 0; k <= 10; ++k) d.class_edges.push_back(0.2 * k);
  auto& entry = d.shapes.emplace_back();
  for (int k = 0; k < 10; ++k) entry.N_V.push_back(std::exp(-3 * 0.2 * k) - std::exp(-3 * 0.2 * (k + 1)));
  const CrystalSizes c = crystal_sizes(d);
  EXPECT_NEAR(c.slope, -3, 1e-9);
  EXPECT_NEAR(c.intercept, std::log(3) + std::log(std::sinh(0.3) / 0.3), 1e-9);
  entry.N_V.assign(10, 0.0);
  EXPECT_EQ(test::code_of([&] { crystal_sizes(d); }), "too-few-profiles");
}

TEST(GrainSize, ThePictureGivesPixelsAndColors) {
  Image image(40, 30, 1, 0.5, Vec3f(0.1f, 0.2f, 0.3f));
  Profiles p = profiles_of({{{5, 5}, {9, 5}, {9, 8}, {5, 8}}});
  p.window = Vec2(20, 15);
  for (int y = 14; y < 20; ++y)  // rows 14 to 19 are 5 to 8 mm from below
    for (int x = 10; x < 18; ++x) image.at(x, y) = Vec3f(0.5f, x < 14 ? 0.25f : 0.75f, 0);
  const auto run = test::run_node("GrainSize", {{"profiles", Value::of(p)}, {"image", Value::of(image)}},
                                  {{"scale", "phi"}});
  const auto& grains = run.output<Table>("grains");
  EXPECT_EQ(grains.number(0, "area pixels"), 48);
  EXPECT_EQ(grains.number(0, "feret min pixels"), 6);
  EXPECT_EQ(grains.number(0, "feret min mm"), 3);
  EXPECT_EQ(grains.number(0, "mean r"), 0.5);
  EXPECT_EQ(grains.number(0, "mean g"), 0.5);
  EXPECT_NEAR(run.output<Table>("table").number(2, "value"), -std::log2(std::sqrt(48 / pi)), 1e-12);
  // The mean of φ of two sizes, of which the first has a quarter of the area.
  Profiles two = profiles_of({{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{2, 0}, {4, 0}, {4, 2}, {2, 2}}});
  two.profiles.emplace_back().weight = 0;  // of no area, and at the border
  two.profiles.back().contour = {{0, 0}, {1, 0}};
  const auto phi = test::run_node("GrainSize", {{"profiles", Value::of(two)}}, {{"scale", "phi"}});
  const auto& rows = phi.output<Table>("table");
  EXPECT_EQ(std::get<std::string>(rows.rows[5][0]), "mean by number");
  EXPECT_NEAR(rows.number(5, "value"), -(std::log2(2 / std::sqrt(pi)) + std::log2(4 / std::sqrt(pi))) / 2,
              1e-12);
  two.profiles.back().weight = 1;
  EXPECT_EQ(test::code_of([&] {
              test::run_node("GrainSize", {{"profiles", Value::of(two)}});
            }),
            "bad-profile");
  p.window = Vec2(21, 15);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("GrainSize", {{"profiles", Value::of(p)}, {"image", Value::of(image)}});
            }),
            "size-mismatch");
  p.profiles[0].contour.clear();
  EXPECT_EQ(test::code_of([&] {
              test::run_node("GrainSize", {{"profiles", Value::of(p)}}, {{"diameter", "feret_min"}});
            }),
            "no-outlines");
  p.profiles[0].weight = 0;
  EXPECT_EQ(test::code_of([&] { test::run_node("GrainSize", {{"profiles", Value::of(p)}}); }), "no-profiles");
}

}  // namespace
}  // namespace terrazzo
