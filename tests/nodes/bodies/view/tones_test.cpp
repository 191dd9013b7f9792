#include "nodes/bodies/view/tones.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/data/luminance.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

std::vector<Vec3f> colors(double power) {
  std::vector<Vec3f> out;
  for (int i = 0; i < 5000; ++i)
    out.push_back(Vec3f(1, 0.8F, 0.5F) *
                  static_cast<float>(0.02 + 0.7 * std::pow(Random(1, 1, i).uniform(), power)));
  return out;
}

std::vector<float> tones_of(const std::vector<Vec3f>& colors) {
  std::vector<float> all;
  for (const Vec3f& c : colors) all.push_back(luminance_of(c));
  std::sort(all.begin(), all.end());
  std::vector<float> tones;
  for (int k = 0; k <= 100; ++k) tones.push_back(all[(all.size() - 1) * k / 100]);
  return tones;
}

TEST(Tones, BecomeThoseOfThePhotographAndKeepTheirOrder) {
  const std::vector<Vec3f> before = colors(1);
  const std::vector<float> wanted = tones_of(colors(1.5));
  std::vector<Vec3f> after = before;
  view::match_tones(after, wanted);
  const std::vector<float> made = tones_of(after);
  for (const int k : {5, 15, 30, 50, 70, 85, 95})
    EXPECT_NEAR(made[k], wanted[k], 0.02F * wanted[k] + 1e-3F) << k;
  for (std::size_t i = 1; i < before.size(); ++i) {
    EXPECT_EQ(before[i - 1].x() < before[i].x(), after[i - 1].x() < after[i].x());
    EXPECT_NEAR(after[i].z() / after[i].x(), 0.5, 1e-4);
  }
}

TEST(Tones, StayWithoutAPhotographAndWithItsOwn) {
  const std::vector<Vec3f> before = colors(1);
  std::vector<Vec3f> after = before;
  view::match_tones(after, {});
  EXPECT_EQ(after, before);
  view::match_tones(after, tones_of(before));
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i].x(), before[i].x(), 0.01F);
  std::vector<Vec3f> one(100, Vec3f::Constant(0.2F));  // one tone
  view::match_tones(one, std::vector<float>(101, 0.3F));
  EXPECT_NEAR(one[50].x(), 0.3, 1e-3);
}

}  // namespace
}  // namespace terrazzo
