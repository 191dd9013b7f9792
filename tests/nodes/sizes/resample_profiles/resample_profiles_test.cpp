// Draws of profiles: how often each appears, and what remains of the areas.
#include "nodes/sizes/resample_profiles/resample_profiles.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using resample_profiles::resample;

Profiles some(int count, int sections) {
  Profiles out;
  out.observed_area = 100;
  out.sections = sections;
  double area = 0;
  for (int i = 0; i < count; ++i) {
    Profile p;
    p.section = i % sections;
    p.area = 0.1 * (1 + i % 5);
    p.centroid = Vec2(i, 0);
    area += p.area;
    out.profiles.push_back(p);
  }
  out.area_fraction = area / out.observed_area;
  return out;
}

double covered(const Profiles& p) {
  double sum = 0;
  for (const Profile& q : p.profiles) sum += q.area;
  return sum;
}

TEST(ResampleProfiles, KeepsTheBinderAndTheProfilesAreas) {
  const Profiles given = some(150, 1);
  for (int draw = 1; draw <= 20; ++draw) {
    const Profiles p = resample(given, draw, 1);
    EXPECT_NEAR(p.area_fraction * p.observed_area, covered(p), 1e-9);
    EXPECT_NEAR(p.observed_area - covered(p), given.observed_area - covered(given), 1e-9);
  }
  const Profiles same = resample(given, 0, 1);
  EXPECT_EQ(same.profiles.size(), given.profiles.size());
  EXPECT_EQ(same.observed_area, given.observed_area);
}

// Each appears 0, 1, 2 … times with the probabilities of a Poisson number of mean 1.
TEST(ResampleProfiles, DrawsPoissonNumbers) {
  const Profiles given = some(200, 1);
  std::map<int, double> share;
  for (int draw = 1; draw <= 50; ++draw) {
    std::map<double, int> times;
    for (const Profile& p : resample(given, draw, 3).profiles) ++times[p.centroid.x()];
    for (int i = 0; i < 200; ++i) share[times[i]] += 1.0 / (200 * 50);
  }
  EXPECT_NEAR(share[0], std::exp(-1), 0.02);
  EXPECT_NEAR(share[1], std::exp(-1), 0.02);
  EXPECT_NEAR(share[2], std::exp(-1) / 2, 0.02);
}

TEST(ResampleProfiles, DrawsWholeSectionsIfThereAreMany) {
  const Profiles p = resample(some(200, 10), 1, 1);
  std::map<int, std::map<double, int>> times;
  for (const Profile& q : p.profiles) ++times[q.section][q.centroid.x()];
  EXPECT_LT(times.size(), 10u);  // some section is not drawn
  for (const auto& [section, own] : times) EXPECT_GT(own.size(), 18u) << section;  // those drawn are whole
}

TEST(ResampleProfiles, DependsOnTheSeedAndTheDrawAlone) {
  const Profiles given = some(60, 1);
  const auto count = [&](int draw, std::uint64_t seed) { return covered(resample(given, draw, seed)); };
  EXPECT_EQ(count(3, 9), count(3, 9));
  EXPECT_NE(count(3, 9), count(4, 9));
  EXPECT_NE(count(3, 9), count(3, 8));
  EXPECT_EQ(test::code_of([] { resample({}, 1, 1); }), "no-profiles");
}

}  // namespace
}  // namespace terrazzo
