#include "nodes/detail/detail_solid/skins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "runtime/random.h"
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
  const auto plain = find_skins(drawn.image, drawn.labels, seen_from_above(drawn, 0.25F), 1).skins;
  ASSERT_EQ(plain.size(), 25U);
  for (const Detail::Skin& skin : plain)
    for (const double x : {-20.0, -10.0, 0.0, 10.0, 20.0}) EXPECT_NEAR(shade_at(skin, x, 3), 0, 0.02);
  const test::DrawnPicture marked = domes(0.4F, 0.2F);
  const auto skins = find_skins(marked.image, marked.labels, seen_from_above(marked, 0.25F), 1).skins;
  ASSERT_EQ(skins.size(), 25U);
  for (const Detail::Skin& skin : skins) {
    const float across = shade_at(skin, 12, 5) - shade_at(skin, -12, 5);
    // The mark's slope is form in part: 0.6 of it, and of the others' slope, which is half as steep, 0.4.
    EXPECT_NEAR(across, skin.profile % 2 == 0 ? 0.078 : -0.028, 0.02) << skin.profile;
  }
}

TEST(Skins, LieWhereTheStoneIs) {
  const test::DrawnPicture drawn = domes(0.4F, 0);
  const auto skins = find_skins(drawn.image, drawn.labels, seen_from_above(drawn, 0.25F), 1).skins;
  ASSERT_EQ(skins.size(), 25U);
  const Detail::Skin& skin = skins[7];  // label 8: third in the second row
  EXPECT_EQ(skin.profile, 8);
  EXPECT_NEAR(skin.corner.x() + 0.1 * skin.center.x(), 20, 0.05);
  EXPECT_NEAR(skin.corner.y() - 0.1 * skin.center.y(), 28, 0.05);
  EXPECT_NEAR(skin.spread(0, 0), kRadius * kRadius / 4, 3);
  EXPECT_NEAR(skin.spread(0, 1), 0, 1);
  EXPECT_NEAR(skin.size, 5.6, 1e-3);
}

// Stones with grain: beyond the outline, each pixel is one of the stone's.
TEST(Skins, ContinueBeyondTheOutlineWithTheirTexture) {
  const test::DrawnPicture drawn = test::draw_disks(400, kStep, kRadius, [](int x, int y, int id) {
    const double grain = Random(7, id, 1000 * y + x).uniform(-0.2, 0.2);
    return linear_to_srgb(Vec3f::Constant(id == 0 ? 0.02F : static_cast<float>(0.3 * std::exp(grain))));
  });
  const auto skins = find_skins(drawn.image, drawn.labels, seen_from_above(drawn, 0.3F), 1).skins;
  ASSERT_EQ(skins.size(), 25U);
  for (const Detail::Skin& skin : skins) {
    std::set<float> own;
    int beyond = 0;
    for (int pass = 0; pass < 2; ++pass)
      for (int y = 0; y < skin.height; ++y)
        for (int x = 0; x < skin.width; ++x) {
          const double r = std::hypot(x + 0.5 - skin.center.x(), y + 0.5 - skin.center.y());
          const float shade = skin.shade[pixel_at(x, y, skin.width)].x();
          if (pass == 0 && r < kRadius) own.insert(shade);
          if (pass == 1 && r > kRadius + 1) {
            const auto next = own.lower_bound(shade - 1e-5F);
            EXPECT_TRUE(next != own.end() && *next <= shade + 1e-5F) << x << " " << y;
            ++beyond;
          }
        }
    EXPECT_GT(beyond, 1000);
  }
}

// A neighbor's shadow reaches from the outline into a fifth of every third stone.
TEST(Skins, HaveNoShadowsOfNeighbors) {
  const test::DrawnPicture drawn = test::draw_disks(400, kStep, kRadius, [](int x, int y, int id) {
    const double grain = Random(7, id, 1000 * y + x).uniform(-0.1, 0.1);
    const bool shadow = x % kStep + 0.5 - 40 < -0.5 * kRadius && id % 3 == 0;
    return linear_to_srgb(
        Vec3f::Constant(id == 0 ? 0.02F : static_cast<float>(0.3 * std::exp(grain - (shadow ? 1.2 : 0)))));
  });
  const auto skins = find_skins(drawn.image, drawn.labels, seen_from_above(drawn, 0.3F), 1).skins;
  ASSERT_EQ(skins.size(), 25U);
  for (const Detail::Skin& skin : skins)
    for (const double x : {-26.0, -23.0, -20.0, 0.0, 20.0})
      EXPECT_GT(shade_at(skin, x, 2), -0.5F) << skin.profile << " " << x;
}

// Waves in all directions, as stains or as the height whose slope toward the light is seen.
TEST(Skins, ReliefIsToldFromStainsByTheDirectionOfTheLight) {
  const double azimuth = 0.6;
  const auto strength = [&](bool relief, bool lit) {
    const test::DrawnPicture drawn = test::draw_disks(400, kStep, kRadius, [&](int x, int y, int id) {
      double sum = 0;
      for (int k = 0; k < 24; ++k) {
        Random random(9, id, k);
        const double direction = std::numbers::pi * (k + random.uniform()) / 24,
                     phase = random.uniform(0, 6.28);
        const double wave = random.uniform(0.6, 1.2);  // per pixel
        const double power = relief ? std::cos(direction - azimuth) : std::numbers::sqrt2 / 2;
        sum += 0.04 * power * std::cos(wave * (std::cos(direction) * x - std::sin(direction) * y) + phase);
      }
      return linear_to_srgb(Vec3f::Constant(id == 0 ? 0.02F : static_cast<float>(0.3 * std::exp(sum))));
    });
    Profiles p = seen_from_above(drawn, 0.3F);
    if (lit) p.light = 0.5 * Vec2(std::cos(azimuth), std::sin(azimuth));
    return find_skins(drawn.image, drawn.labels, p, 1).relief.strength;
  };
  EXPECT_GT(strength(true, true), 5);
  EXPECT_LT(strength(false, true), 0.3);
  EXPECT_EQ(strength(true, false), 0);
}

TEST(Skins, AreOfStonesThatNothingHidesOnASurface) {
  const test::DrawnPicture drawn = domes(0.4F, 0);
  Profiles p = seen_from_above(drawn, 0.25F);
  p.profiles[3].touches_border = true;           // its texture continues
  p.profiles[4].whole = 2 * p.profiles[4].area;  // half of it is hidden
  EXPECT_EQ(find_skins(drawn.image, drawn.labels, p, 1).skins.size(), 24U);
  p.view = View::Section;
  EXPECT_TRUE(find_skins(drawn.image, drawn.labels, p, 1).skins.empty());
  p.view = View::Surface;
  p.profiles.pop_back();
  EXPECT_EQ(test::code_of([&] { find_skins(drawn.image, drawn.labels, p, 1); }), "size-mismatch");
}

}  // namespace
}  // namespace terrazzo
