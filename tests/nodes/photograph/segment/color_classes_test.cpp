#include "nodes/photograph/segment/color/color_classes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace segment;

// An ellipse of the given area and aspect ratio.
Profile profile(double area, double aspect, const Vec3f& color) {
  Profile p;
  p.area = area;
  p.color = color;
  const double a = std::sqrt(area * aspect / std::numbers::pi), b = a / aspect;
  for (int k = 0; k < 60; ++k)
    p.contour.push_back(
        {a * std::cos(2 * std::numbers::pi * k / 60), b * std::sin(2 * std::numbers::pi * k / 60)});
  return p;
}

struct Kind {
  int count;
  double size, aspect;
  Vec3f color;
};

Profiles mix(const std::vector<Kind>& kinds, std::uint64_t seed) {
  Random r(seed);
  Profiles out;
  for (const Kind& k : kinds)
    for (int i = 0; i < k.count; ++i) {
      const double size = k.size * r.uniform(0.5, 1.5);
      const float shade = static_cast<float>(r.uniform(0.9, 1.1));
      out.profiles.push_back(profile(size * size, k.aspect, shade * k.color));
    }
  return out;
}

const Vec3f kRed(0.4f, 0.05f, 0.05f), kBlue(0.05f, 0.1f, 0.5f), kWhite(0.8f, 0.8f, 0.8f);

int count(const std::vector<int>& classes) {
  return static_cast<int>(std::set(classes.begin(), classes.end()).size());
}

TEST(ColorClasses, ColorsWithSizesOfTheirOwnAreClasses) {
  for (int seed = 1; seed <= 10; ++seed) {
    const auto found = color_classes(mix({{60, 2, 1.3, kRed}, {90, 1, 1.3, kBlue}}, seed), 0, 1, {});
    ASSERT_EQ(count(found), 2) << seed;
    for (int i = 0; i < 150; ++i) EXPECT_EQ(found[i], i < 60 ? 1 : 0);  // the most frequent is class 0
  }
}

TEST(ColorClasses, ColorsWithShapesOfTheirOwnAreClasses) {
  EXPECT_EQ(count(color_classes(mix({{60, 1, 1, kRed}, {60, 1, 2, kBlue}}, 1), 0, 1, {})), 2);
}

TEST(ColorClasses, ColorsOfEqualParticlesAreOneClass) {
  int one = 0;
  for (int seed = 1; seed <= 50; ++seed)
    one += count(color_classes(mix({{60, 1, 1.3, kRed}, {90, 1, 1.3, kBlue}}, seed), 0, 1, {})) == 1;
  EXPECT_GE(one, 49);
}

TEST(ColorClasses, TwoOfThreeColorsAreAlike) {
  const auto found =
      color_classes(mix({{60, 1, 1.3, kRed}, {90, 3, 1.3, kBlue}, {70, 1, 1.3, kWhite}}, 4), 0, 1, {});
  EXPECT_EQ(count(found), 2);
  EXPECT_EQ(found[0], found[219]);
  EXPECT_NE(found[0], found[100]);
}

TEST(ColorClasses, AFewProfilesJoinTheNearestColor) {
  const auto found = color_classes(
      mix({{60, 2, 1.3, kRed}, {90, 1, 1.3, kBlue}, {5, 9, 3, {0.5f, 0.1f, 0.1f}}}, 2), 0, 1, {});
  EXPECT_EQ(count(found), 2);
  EXPECT_EQ(found[152], found[0]);
}

TEST(ColorClasses, ANumberIsTakenAsItIs) {
  EXPECT_EQ(count(color_classes(mix({{20, 1, 1.3, kRed}, {30, 1, 1.3, kBlue}}, 1), 2, 1, {})), 2);
  EXPECT_TRUE(color_classes({}, 0, 1, {}).empty());
}

TEST(ColorClasses, SignificanceHasItsClosedForm) {
  EXPECT_EQ(kolmogorov_smirnov({}, {1, 2}), 1);
  EXPECT_EQ(kolmogorov_smirnov({1, 2, 3}, {1, 2, 3}), 1);
  std::vector<double> low, high, shifted;
  for (int i = 0; i < 400; ++i) {
    low.push_back(i);
    high.push_back(1000 + i);
    shifted.push_back(i + 38.4);
  }
  EXPECT_LT(kolmogorov_smirnov(low, high), 1e-12);
  // The distance 1.358·√(2/n) is exceeded with a probability of 5 %; 38.4 of 400 are 39 places.
  EXPECT_NEAR(kolmogorov_smirnov(low, shifted), 0.045, 0.006);
  EXPECT_EQ(kolmogorov_smirnov(low, shifted), kolmogorov_smirnov(shifted, low));
}

TEST(ColorClasses, SignificanceIsUniformForEqualDistributions) {
  int below = 0;
  for (int seed = 1; seed <= 1000; ++seed) {
    Random r(seed);
    std::vector<double> a, b;
    for (int i = 0; i < 80; ++i) a.push_back(r.uniform());
    for (int i = 0; i < 120; ++i) b.push_back(r.uniform());
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    below += kolmogorov_smirnov(a, b) < 0.1;
  }
  EXPECT_NEAR(below, 100, 30);
}

}  // namespace
}  // namespace terrazzo
