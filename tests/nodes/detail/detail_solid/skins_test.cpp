#include "nodes/detail/detail_solid/skins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/nodes/detail/detail_solid/drawn_picture.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

constexpr int kStep = 80;
constexpr double kRadius = 28;

// Domes that grow darker from the middle outwards by `form` in the logarithm, with a mark on the right half
// of those with an even label.
test::DrawnPicture domes(float form, float mark) {
  return test::draw_disks(400, kStep, kRadius, [=](int x, int y, int id) {
    if (id == 0) return Vec3f(Vec3f::Constant(0.1F));
    const double dx = x % kStep + 0.5 - 40;
    const double dy = y % kStep + 0.5 - 40;
    const auto r = static_cast<float>(std::hypot(dx, dy) / kRadius);
    float logarithm = -form * r * r;
    if (id % 2 == 0 && dx > 0) logarithm += mark;
    return linear_to_srgb(Vec3f::Constant(0.3F * std::exp(logarithm)));
  });
}

Profiles seen_from_above(const test::DrawnPicture& drawn, float color) {
  Profiles p;
  p.view = View::Surface;
  for (int k = 0; k < drawn.labels.count(); ++k) {
    Profile q;
    q.area = q.whole = std::numbers::pi * std::pow(kRadius * 0.1, 2);
    q.color = Vec3f::Constant(color);
    p.profiles.push_back(q);
  }
  return p;
}

float shade_at(const Detail::Skin& skin, double x, double y) {
  return skin
      .shade[pixel_at(static_cast<int>(skin.center.x() + x), static_cast<int>(skin.center.y() + y),
                      skin.width)]
      .x();
}

TEST(Skins, KeepMarksAndLoseTheFormThatAllStonesHave) {
  const test::DrawnPicture drawn = domes(0.4F, 0);
  const auto plain = find_skins(drawn.image, drawn.labels, seen_from_above(drawn, 0.25F));
  ASSERT_EQ(plain.size(), 25U);
  for (const Detail::Skin& skin : plain)
    for (const double x : {-20.0, -10.0, 0.0, 10.0, 20.0}) EXPECT_NEAR(shade_at(skin, x, 3), 0, 0.02);
  const test::DrawnPicture marked = domes(0.4F, 0.2F);
  const auto skins = find_skins(marked.image, marked.labels, seen_from_above(marked, 0.25F));
  ASSERT_EQ(skins.size(), 25U);
  for (const Detail::Skin& skin : skins) {
    const float across = shade_at(skin, 12, 5) - shade_at(skin, -12, 5);
    // The mark's slope is form in part: 0.6 of it, and of the others' slope, which is half as steep, 0.4.
    EXPECT_NEAR(across, skin.profile % 2 == 0 ? 0.078 : -0.028, 0.02) << skin.profile;
  }
}

TEST(Skins, LieWhereTheStoneIs) {
  const test::DrawnPicture drawn = domes(0.4F, 0);
  const auto skins = find_skins(drawn.image, drawn.labels, seen_from_above(drawn, 0.25F));
  ASSERT_EQ(skins.size(), 25U);
  const Detail::Skin& skin = skins[7];  // label 8: third in the second row
  EXPECT_EQ(skin.profile, 8);
  EXPECT_NEAR(skin.corner.x() + 0.1 * skin.center.x(), 20, 0.05);
  EXPECT_NEAR(skin.corner.y() - 0.1 * skin.center.y(), 28, 0.05);
  EXPECT_NEAR(skin.spread(0, 0), kRadius * kRadius / 4, 3);
  EXPECT_NEAR(skin.spread(0, 1), 0, 1);
  EXPECT_NEAR(skin.size, 5.6, 1e-3);
}

TEST(Skins, ContinueBeyondTheOutlineAsTheirMirrorImage) {
  const test::DrawnPicture marked = domes(0, 1);
  const auto skins = find_skins(marked.image, marked.labels, seen_from_above(marked, 0.3F));
  ASSERT_EQ(skins.size(), 25U);
  for (const Detail::Skin& skin : skins) {
    const float inside = shade_at(skin, 22, 2) - shade_at(skin, -22, 2);
    const float outside = shade_at(skin, 31, 2) - shade_at(skin, -31, 2);
    EXPECT_NEAR(outside, inside, 0.05) << skin.profile;
    if (skin.profile % 2 == 0) EXPECT_GT(std::abs(outside), 0.05F) << skin.profile;
  }
}

TEST(Skins, AreOfWholeStonesOfASurface) {
  const test::DrawnPicture drawn = domes(0.4F, 0);
  Profiles p = seen_from_above(drawn, 0.25F);
  p.profiles[3].touches_border = true;
  p.profiles[4].whole = 2 * p.profiles[4].area;  // half of it is hidden
  EXPECT_EQ(find_skins(drawn.image, drawn.labels, p).size(), 23U);
  p.view = View::Section;
  EXPECT_TRUE(find_skins(drawn.image, drawn.labels, p).empty());
  p.view = View::Surface;
  p.profiles.pop_back();
  EXPECT_EQ(test::code_of([&] { find_skins(drawn.image, drawn.labels, p); }), "size-mismatch");
}

}  // namespace
}  // namespace terrazzo
