// Two-point correlation and lineal path of labeled sections.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/compare/compare/comparison.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace compare;

// Disks that touch no other, at random.
Labels disks(std::uint64_t seed, int sections, double radius, double share, int size = 256) {
  Labels l;
  l.width = l.height = size;
  l.sections = sections;
  l.pixel_size = 0.5;
  l.ids.assign(static_cast<std::size_t>(size) * size * sections, 0);
  Random random(seed);
  for (int s = 0; s < sections; ++s) {
    double covered = 0;
    while (covered < share * size * size) {
      const double x = random.uniform(0, size), y = random.uniform(0, size);
      std::vector<std::size_t> inside;
      bool free = true;
      for (int v = std::max(0, static_cast<int>(y - radius)); v < std::min(size + 0.0, y + radius); ++v)
        for (int u = std::max(0, static_cast<int>(x - radius)); u < std::min(size + 0.0, x + radius); ++u)
          if (std::hypot(u - x, v - y) < radius) {
            inside.push_back(l.index(u, v, s));
            free &= l.ids[inside.back()] == 0;
          }
      if (!free) continue;
      l.classes.push_back(0);
      for (const std::size_t i : inside) l.ids[i] = l.count();
      covered += static_cast<double>(inside.size());
    }
  }
  return l;
}

double of(const Comparison& c, const std::string& item, double ComparedNumber::*what = &ComparedNumber::b) {
  for (const auto& n : c.numbers)
    if (n.item == item + ", largest difference") return n.*what;
  ADD_FAILURE() << "no " << item;
  return NAN;
}

Comparison compare_labels(const Labels& a, const Labels& b) {
  Comparison c;
  compare_phases(a, b, {}, c, {});
  return c;
}

TEST(ComparePhases, OneSetTwiceDoesNotDiffer) {
  const Labels l = disks(1, 1, 10, 0.3);
  const Comparison c = compare_labels(l, l);
  ASSERT_EQ(c.numbers.size(), 3u);
  for (const auto& n : c.numbers) EXPECT_EQ(n.b, 0) << n.item;
}

// Rows alternate between eight of one particle and eight of binder. Along rows, every curve is constant, at ½
// for particles and binder. Along columns, S2 is a triangle wave, and paths end within eight pixels.
TEST(ComparePhases, StripesHaveTheirClosedForm) {
  const auto stripes = [](int thickness) {
    Labels l;
    l.width = l.height = 128;
    l.pixel_size = 0.25;
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x) l.ids.push_back(y / thickness % 2 ? y / thickness / 2 + 1 : 0);
    l.classes.assign(static_cast<std::size_t>(64 / thickness), 0);
    return l;
  };
  const Comparison c = compare_labels(stripes(8), stripes(16));
  // Along columns at r = 16: S2 is ½ for thickness 8 (a whole period) and 0 for 16 (half a period).
  EXPECT_NEAR(of(c, "particles"), 0.25, 0.02);
  // Largest difference of max(0, 1 − r/8)/2 and max(0, 1 − r/16)/2, at r = 8: ¼, halved by the rows.
  EXPECT_NEAR(of(c, "one particle"), 0.125, 0.015);
  EXPECT_NEAR(of(c, "binder"), 0.125, 0.015);
}

TEST(ComparePhases, SamplesOfOneThingStayWithinTheNoise) {
  int exceeding = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed)
    for (const auto& n : compare_labels(disks(2 * seed, 1, 10, 0.3), disks(2 * seed + 1, 8, 10, 0.3)).numbers)
      exceeding += n.exceeds();
  EXPECT_LE(exceeding, 6);  // of 36; 1.8 are expected
}

TEST(ComparePhases, LargerParticlesExceedIt) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Comparison c = compare_labels(disks(seed, 1, 10, 0.3), disks(seed + 50, 8, 14, 0.3));
    EXPECT_GT(of(c, "one particle"), of(c, "one particle", &ComparedNumber::tolerance)) << seed;
  }
}

TEST(ComparePhases, DoesNotDependOnThePixelSize) {
  const Labels fine = disks(5, 1, 16, 0.3);
  Labels coarse = fine;
  coarse.width = coarse.height = 128;
  coarse.pixel_size = 1;
  coarse.ids.clear();
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) coarse.ids.push_back(fine.ids[fine.index(2 * x, 2 * y)]);
  const Comparison c = compare_labels(fine, coarse);
  for (const auto& n : c.numbers) EXPECT_LT(n.b, 0.02) << n.item;
}

// A third of the disks was missed. With their pixels unobserved, the rest looks like other sections again.
TEST(ComparePhases, WhatWasNotObservedDoesNotCount) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Labels other = disks(seed + 70, 8, 10, 0.45);
    Labels missed = disks(seed + 60, 1, 10, 0.45), unobserved = missed;
    for (std::size_t i = 0; i < missed.ids.size(); ++i)
      if (missed.ids[i] % 3 == 1) {
        missed.ids[i] = 0;
        unobserved.ids[i] = -1;
      }
    const Comparison without = compare_labels(missed, other), with = compare_labels(unobserved, other);
    for (const char* item : {"particles", "binder"})
      EXPECT_LT(of(with, item), 0.75 * of(without, item)) << item << seed;
  }
}

TEST(ComparePhases, TheNodeWantsBothLabelsOrNone) {
  Profiles p;
  p.observed_area = 100;
  Profile q;
  q.area = 1;
  p.profiles.assign(30, q);
  const Value profiles = Value::of(p), labels = Value::of(disks(1, 1, 10, 0.3, 128));
  const auto all = test::run_node(
      "Compare", {{"a", profiles}, {"b", profiles}, {"labels_a", labels}, {"labels_b", labels}}, {});
  EXPECT_EQ(all.metrics.at("two_point_difference"), 0);
  EXPECT_EQ(all.metrics.at("lineal_path_difference"), 0);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Compare", {{"a", profiles}, {"b", profiles}, {"labels_a", labels}}, {});
            }),
            "missing-input");
  const Value image = Value::of(Image(64, 64, 1, 1));
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Compare",
                             {{"a", image}, {"b", image}, {"labels_a", labels}, {"labels_b", labels}}, {});
            }),
            "different-types");
}

}  // namespace
}  // namespace terrazzo
