#include "nodes/compare/compare/comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/data/labels.h"
#include "runtime/random.h"
#include "tests/nodes/compare/compare/exceeding.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace compare;

using test::run_node;

// Disks of lognormal diameter, with an approximately Poisson-distributed count.
Profiles random_profiles(std::uint64_t seed, int n, double area, double mean = 0.2,
                         const Vec3f& color = Vec3f(0.4f, 0.3f, 0.2f)) {
  Profiles p;
  p.observed_area = area;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    Random r(seed, 1, i);
    const double d = mean * std::exp(0.35 * r.normal());
    Profile q;
    q.area = M_PI / 4 * d * d;
    q.color = color * static_cast<float>(1 + 0.1 * r.normal());
    sum += q.area;
    p.profiles.push_back(q);
  }
  p.area_fraction = sum / area;
  p.binder_color = Vec3f(0.05f, 0.05f, 0.05f);
  return p;
}

int poisson(std::uint64_t seed, double mean) {  // accurate enough for the noise of a sum
  Random r(seed, 2, 0);
  return static_cast<int>(std::lround(mean + std::sqrt(mean) * r.normal()));
}

TEST(Compare, EqualSetsDoNotDiffer) {
  const Profiles p = random_profiles(1, 500, 100);
  const Comparison c = compare::compare(p, p, {});
  ASSERT_FALSE(c.numbers.empty());
  for (const auto& n : c.numbers) {
    EXPECT_EQ(n.a, n.b);
    EXPECT_FALSE(n.exceeds());
  }
  EXPECT_EQ(c.metrics.at("N_A_l1"), 0);
  EXPECT_EQ(c.metrics.at("area_fraction_ratio"), 1);
  EXPECT_EQ(c.metrics.at("color_difference_particles"), 0);
  EXPECT_TRUE(c.warnings.empty());
}

TEST(Compare, ClassesAddUpToTheDensity) {
  Profiles a = random_profiles(1, 500, 100), b = random_profiles(2, 300, 50);
  for (std::size_t i = 0; i < b.profiles.size(); i += 3) b.profiles[i].weight = i % 2 ? 0 : 1.7;
  const Comparison c = compare::compare(a, b, {});
  double sum_a = 0, sum_b = 0, weights = 0;
  int bins = 0;
  for (const auto& n : c.numbers)
    if (n.upper > n.lower) sum_a += n.a, sum_b += n.b, ++bins;
  for (const Profile& p : b.profiles) weights += p.weight;
  EXPECT_EQ(bins, 10);
  EXPECT_NEAR(sum_a, 5, 1e-12);
  EXPECT_NEAR(sum_b, weights / 50, 1e-12);
  EXPECT_NEAR(c.metrics.at("N_A_b"), weights / 50, 1e-12);
}

TEST(Compare, SamplesOfOneThingStayWithinTheNoise) {
  // With 95 % intervals, about 30 of 60 repetitions × 10 classes exceed by chance, fewer because intervals of
  // sparse classes are conservative.
  int beyond = 0, fractions = 0, tested = 0;
  for (int i = 0; i < 60; ++i) {
    const Comparison c = compare::compare(random_profiles(100 + i, poisson(i, 600), 100),
                                          random_profiles(500 + i, poisson(1000 + i, 300), 50), {});
    for (const auto& n : c.numbers)
      if (n.upper > n.lower) ++tested, beyond += n.exceeds();
    fractions += exceeding(c, "area_fraction");
  }
  EXPECT_EQ(tested, 600);
  EXPECT_LE(beyond, 45);
  EXPECT_GE(beyond, 5);
  EXPECT_LE(fractions, 9);
}

TEST(Compare, KnownDifferencesExceedTheNoise) {
  const Profiles a = random_profiles(1, 800, 100);
  const Comparison size = compare::compare(a, random_profiles(2, 800, 100, 0.26), {});
  EXPECT_GE(exceeding(size, "size_classes"), 3);
  EXPECT_EQ(exceeding(size, "area_fraction"), 1);
  EXPECT_NEAR(size.metrics.at("area_fraction_ratio"), 1.69, 0.15);
  EXPECT_EQ(exceeding(size, "color"), 0);
  const Comparison color =
      compare::compare(a, random_profiles(3, 800, 100, 0.2, Vec3f(0.2f, 0.3f, 0.4f)), {});
  EXPECT_GE(exceeding(color, "color"), 2);
  EXPECT_LE(exceeding(color, "size_classes"), 1);  // one row in twenty exceeds by chance
  const Vec3f la = linear_to_oklab(Vec3f(0.4f, 0.3f, 0.2f)), lb = linear_to_oklab(Vec3f(0.2f, 0.3f, 0.4f));
  EXPECT_NEAR(color.metrics.at("color_difference_particles"), (la - lb).norm(), 0.01);
}

TEST(Compare, UnknownAreasAreSaid) {
  Profiles a = random_profiles(1, 400, 100), b = random_profiles(2, 400, 100);
  b.observed_area = 0;
  Comparison c = compare::compare(a, b, {});
  ASSERT_EQ(c.warnings.size(), 1u);
  double shares = 0;
  for (const auto& n : c.numbers)
    if (n.upper > n.lower) shares += n.b;
  EXPECT_NEAR(shares, 1, 1e-12);
  EXPECT_EQ(c.metrics.count("N_A_b"), 0u);
  b = random_profiles(2, 400, 100);
  const double fraction = b.area_fraction;
  b.area_fraction = 0;
  c = compare::compare(a, b, {});
  EXPECT_EQ(c.warnings.size(), 1u);
  EXPECT_NEAR(c.metrics.at("area_fraction_b"), fraction, 1e-12);
}

TEST(Compare, SmallestLeavesOutWhatAPhotographCannotShow) {
  const Profiles a = random_profiles(1, 500, 100);
  Profiles b = a;
  for (int i = 0; i < 300; ++i) {
    Profile speck;
    speck.area = 1e-4;
    b.profiles.push_back(speck);
  }
  CompareOptions choice;
  EXPECT_GT(compare::compare(a, b, choice).metrics.at("N_A_l1"), 0.5);
  choice.smallest = 0.05;
  EXPECT_EQ(compare::compare(a, b, choice).metrics.at("N_A_l1"), 0);
}

SizeDistribution distribution(const std::vector<double>& edges, const std::vector<double>& N_V,
                              double spread) {
  SizeDistribution d;
  d.class_edges = edges;
  SizeDistribution::Entry e;
  e.N_V = N_V;
  for (double v : N_V) {
    e.low.push_back(v * (1 - spread));
    e.high.push_back(v * (1 + spread));
  }
  d.shapes = {e};
  d.d_max = edges.back();
  return d;
}

TEST(CompareDistributions, ByClassAndReclassed) {
  const auto a = distribution({0, 1, 2}, {4, 2}, 0.2), b = distribution({0, 1, 2}, {4.5, 2}, 0.2);
  const Comparison same = compare::compare(a, b, {});
  EXPECT_NEAR(same.metrics.at("N_V_l1"), 0.5 / 6, 1e-12);
  EXPECT_EQ(exceeding(same, "size_classes"), 0);
  CompareOptions two;
  two.classes = 2;
  const Comparison other = compare::compare(a, distribution({0, 0.5, 2}, {3, 3}, 0), two);
  ASSERT_EQ(other.numbers.size(), 3u);
  EXPECT_NEAR(other.numbers[0].b, 4, 1e-12);  // 3 plus a third of 3
  EXPECT_NEAR(other.numbers[1].b, 2, 1e-12);
  EXPECT_EQ(other.metrics.at("N_V_b"), 6);
  EXPECT_EQ(exceeding(compare::compare(a, distribution({0, 1, 2}, {9, 2}, 0.2), {}), "size_classes"), 2);
}

TEST(CompareDistributions, RelativeDensitiesHaveNoUnit) {
  auto a = distribution({0, 1, 2}, {4, 2}, 0.2);  // without a volume fraction
  for (const auto& n : compare::compare(a, a, {}).numbers) EXPECT_EQ(n.unit, "relative");
  a.volume_fraction = 0.3;
  for (const auto& n : compare::compare(a, a, {}).numbers) EXPECT_EQ(n.unit, "mm⁻³");
}

Image noise_image(std::uint64_t seed, const Vec3f& color) {
  Image image(64, 48, 1, 1);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = color * static_cast<float>(1 + 0.2 * Random(seed, 0, i).uniform());
  return image;
}

TEST(CompareImages, ByMeanAndHistogram) {
  const Image a = noise_image(1, Vec3f(0.3f, 0.3f, 0.3f)), b = noise_image(2, Vec3f(0.3f, 0.3f, 0.3f)),
              c = noise_image(3, Vec3f(0.6f, 0.3f, 0.3f));
  EXPECT_EQ(compare::compare(a, a, {}).metrics.at("histogram_distance_L"), 0);
  EXPECT_EQ(exceeding(compare::compare(a, a, {}), "color"), 0);
  EXPECT_LT(compare::compare(a, b, {}).metrics.at("color_difference_image"), 0.005);
  EXPECT_GE(exceeding(compare::compare(a, c, {}), "color"), 4);
  EXPECT_GT(compare::compare(a, c, {}).metrics.at("histogram_distance_a"), 0.03);
}

TEST(CompareNode, GivesTableFigureAndMetrics) {
  const Value a = Value::of(random_profiles(1, 500, 100)), b = Value::of(random_profiles(2, 900, 100));
  const auto run =
      run_node("Compare", {{"a", a}, {"b", b}}, {{"classes", "8"}, {"names", "[photograph, solid]"}});
  const Table& t = run.output<Table>("table");
  ASSERT_EQ(t.column("exceeds"), 9);
  double exceeds = 0;
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    exceeds += t.number(i, "exceeds");
    EXPECT_NEAR(t.number(i, "difference"), t.number(i, "b") - t.number(i, "a"), 1e-12);
  }
  EXPECT_EQ(run.metrics.at("exceeding"), exceeds);
  EXPECT_GT(exceeds, 1);
  EXPECT_GT(run.output<Image>("figure").width, 1000);
  const auto one = run_node("Compare", {{"a", a}, {"b", b}}, {{"measures", "[area_fraction]"}});
  EXPECT_EQ(one.output<Table>("table").rows.size(), 1u);
}

std::string code_of(const Value& a, const Value& b,
                    const std::map<std::string, std::string>& parameters = {}) {
  return test::code_of([&] { run_node("Compare", {{"a", a}, {"b", b}}, parameters); });
}

TEST(CompareNode, SaysWhatIsWrong) {
  const Value profiles = Value::of(random_profiles(1, 50, 10)),
              image = Value::of(noise_image(1, Vec3f::Ones()));
  const Value sizes = Value::of(distribution({0, 1, 2}, {4, 2}, 0.2));
  EXPECT_EQ(code_of(profiles, profiles), "");
  EXPECT_EQ(code_of(profiles, image), "different-types");
  EXPECT_EQ(code_of(profiles, Value::of(Profiles{})), "no-profiles");
  EXPECT_EQ(code_of(sizes, Value::of(SizeDistribution{})), "no-classes");
  EXPECT_EQ(code_of(image, Value::of(Image{})), "no-pixels");
  EXPECT_EQ(code_of(image, image, {{"measures", "[size_classes]"}}), "no-such-measure");
  EXPECT_EQ(code_of(profiles, profiles, {{"measures", "[colour]"}}), "bad-value");
  EXPECT_EQ(code_of(profiles, Value::of(Labels{})), "unknown-port");
  Profiles nan = random_profiles(1, 50, 10);
  nan.profiles[3].area = NAN;
  EXPECT_EQ(code_of(profiles, Value::of(nan)), "bad-profile");
  Image dark(4, 4, 1, 1);
  dark.at(1, 1).x() = NAN;
  EXPECT_EQ(code_of(image, Value::of(dark)), "bad-pixels");
}

TEST(CompareNode, SetsWithoutWholeProfilesWarn) {
  Profiles cut = random_profiles(1, 50, 10);
  for (Profile& p : cut.profiles) p.weight = 0;
  const auto run = run_node("Compare", {{"a", Value::of(cut)}, {"b", Value::of(cut)}});
  EXPECT_FALSE(run.warnings.empty());
  EXPECT_EQ(run.metrics.count("N_A_l1"), 0u);
  EXPECT_EQ(run.metrics.at("area_fraction_ratio"), 1);
}

}  // namespace
}  // namespace terrazzo
