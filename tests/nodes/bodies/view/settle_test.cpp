#include "nodes/bodies/view/settle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/bodies/view/bed.h"
#include "runtime/random.h"
#include "tests/nodes/bodies/section/packing.h"
#include "tests/nodes/volumes/voxelize/bodies.h"

namespace terrazzo {
namespace {
using namespace view;

using Stones = std::vector<carving::RayScene::Instance>;

constexpr float kCell = 0.05f;

Shapes unit_ball() {
  Mesh mesh = test::sphere_mesh(4);
  for (Vec3& v : mesh.vertices) v *= 2;  // radius 1 mm
  return test::one_shape(std::move(mesh));
}

const StoneMeshes& balls() {
  static const StoneMeshes meshes(unit_ball());
  return meshes;
}

carving::RayScene::Instance ball_at(const Vec3f& center, float radius) {
  carving::RayScene::Instance stone;
  stone.linear *= radius;
  stone.offset = center;
  return stone;
}

float radius_of(const carving::RayScene::Instance& ball) { return ball.linear(0, 0); }

// A picture of 10 mm × 10 mm of stones up to 4 mm.
SettleOptions on_soil(float height) {
  SettleOptions options;
  options.picture = Vec2(10, 10);
  options.largest = 4;
  options.cell = kCell;
  options.deepest = -20;
  options.soil = height;
  options.level = height;
  return options;
}

Stones settled(Stones stones, const SettleOptions& options) {
  settle(balls().triangles, stones, options);
  return stones;
}

// How far the two nearest balls overlap, mm; negative if they don't.
float overlap_in(const Stones& stones) {
  float most = -100;
  for (std::size_t a = 0; a < stones.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const float apart = (stones[a].offset - stones[b].offset).norm();
      most = std::max(most, radius_of(stones[a]) + radius_of(stones[b]) - apart);
    }
  return most;
}

// Balls of two size ranges that are apart, in a box of 10 mm whose top is the cut.
Stones random_balls(std::uint64_t seed) {
  const Particles p = test::apart_particles(seed, 1500, 10, 0.3, 1.6, unit_ball().shapes[0]);
  Stones stones;
  for (std::size_t i = 0; i < p.count(); ++i) {
    const Vec3f center = (p.position[i] - Vec3(0, 0, 10)).cast<float>();
    stones.push_back(ball_at(center, static_cast<float>(p.scale[i])));
  }
  return stones;
}

bool same_places(const Stones& a, const Stones& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& s, const auto& t) { return s.offset == t.offset; });
}

TEST(Settle, RollsASmallBallDownTheFlankOfABigOne) {
  // The big one's center is below the soil, so that it stays.
  const Stones before = {ball_at({5, 5, -0.1f}, 2), ball_at({6.2f, 5, 3}, 0.5f)};
  const Stones after = settled(before, on_soil(0));
  EXPECT_EQ(after[0].offset, before[0].offset);
  EXPECT_NEAR(after[1].offset.z(), 0.5f - kBuried, kCell);  // on the soil
  const float aside = (after[1].offset - after[0].offset).norm();
  EXPECT_NEAR(aside, 2.5f, 3 * kCell);
  EXPECT_NEAR(after[1].offset.y(), 5, 2 * kCell);  // straight down the flank
  EXPECT_LT(overlap_in(after), kCell);
}

TEST(Settle, BuriesABallInSoil) {
  for (const float radius : {0.3f, 1.0f, 2.0f}) {
    const Stones after = settled({ball_at({4, 6, 5}, radius)}, on_soil(1));
    EXPECT_NEAR(after[0].offset.z() - radius, 1 - kBuried * 2 * radius, 0.01f * radius);
    EXPECT_EQ(after[0].offset.head<2>(), Eigen::Vector2f(4, 6));
  }
}

TEST(Settle, LaysABallOnTopOfABallAndBetweenThree) {
  // Exactly above another one a ball balances; anywhere else it rolls off, and three hold it in their middle.
  const float side = 2.2f;
  const float away = side / std::sqrt(3.0f);
  const Vec3f middle(5, 5, -0.01f);
  Stones stones;
  for (const float turn : {0.3f, 2.3944f, 4.4888f})
    stones.push_back(ball_at(middle + away * Vec3f(std::cos(turn), std::sin(turn), 0), 1));
  stones.push_back(ball_at({5.3f, 4.8f, 4}, 1));
  const Stones after = settled(stones, on_soil(0));
  const float rest = std::sqrt(4 - away * away);
  EXPECT_NEAR(after[3].offset.x(), 5, 2 * kCell);
  EXPECT_NEAR(after[3].offset.y(), 5, 2 * kCell);
  EXPECT_NEAR(after[3].offset.z(), rest, 2 * kCell);
  EXPECT_LT(overlap_in(after), kCell);
}

TEST(Settle, RollsAtMostAsFarAsItMay) {
  // The way down is 2 mm.
  const Stones after = settled({ball_at({5, 5, -0.1f}, 2), ball_at({5.1f, 5, 3}, 0.06f)}, on_soil(0));
  const float rolled = (after[1].offset - Vec3f(5.1f, 5, 3)).head<2>().norm();
  EXPECT_LT(rolled, kFarthest * (0.12f + 2 * kCell) + 1e-3f);
  EXPECT_GT(rolled, 0.5f);
  EXPECT_LT(overlap_in(after), kCell);
}

TEST(Settle, LeavesStonesBelowTheLevelAndFarOutside) {
  const Stones before = {ball_at({5, 5, -1}, 1), ball_at({-5, 5, 4}, 1), ball_at({5, 15, 4}, 0.5f)};
  EXPECT_TRUE(same_places(settled(before, on_soil(0)), before));
}

TEST(Settle, FindsTheExposureThatAShareNeeds) {
  // Of 100 mm², the first covers 4π mm² of the ground, the second 2.25π, the third nothing, being below, and
  // the fourth nothing of the picture.
  const Stones stones = {ball_at({3, 3, 1}, 2), ball_at({7, 7, 3}, 1.5f), ball_at({5, 5, -6}, 1),
                         ball_at({15, 5, 0}, 1.1f)};
  std::vector<float> exposures;
  for (const auto& stone : stones)
    exposures.push_back(stone.offset.z() / reach_below(balls().triangles[0], stone.linear));
  EXPECT_NEAR(exposures[2], -6, 0.01);
  const auto needed = [&](double share) {
    return exposure_of_share(balls().triangles, stones, exposures, on_soil(0), share);
  };
  const double first = 4 * std::numbers::pi / 100;
  EXPECT_NEAR(needed(0.9 * first), 0.5, 0.01);
  EXPECT_NEAR(needed(1.2 * first), 2, 0.01);
  EXPECT_NEAR(needed(0.9), 2, 0.01);  // all together cover less
}

TEST(Settle, NothingRisesOrOverlapsInAnyBed) {
  int moved = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Stones before = random_balls(seed);
    ASSERT_GT(before.size(), 60u);
    ASSERT_LE(overlap_in(before), 0);
    const float soil = -4;
    SettleOptions options = on_soil(soil);
    if (seed % 2 == 0) options.soil.reset();
    const Stones after = settled(before, options);
    EXPECT_LT(overlap_in(after), kCell) << seed;
    for (std::size_t i = 0; i < after.size(); ++i) {
      const float r = radius_of(after[i]);
      const float z = after[i].offset.z();
      EXPECT_LE(z, before[i].offset.z()) << seed << " " << i;
      if (after[i].offset == before[i].offset) continue;
      ++moved;
      EXPECT_GE(z - r, (options.soil ? soil - kBuried * 2 * r : -20.0f) - 0.01f) << seed << " " << i;
      EXPECT_LE((after[i].offset - before[i].offset).head<2>().norm(),
                kFarthest * (2 * r + 2 * kCell) + 1e-3f)
          << seed << " " << i;
    }
    EXPECT_TRUE(same_places(after, settled(before, options))) << seed;
  }
  EXPECT_GT(moved, 60);
}

// What carries each moved ball: another ball or the soil, within a few cells.
TEST(Settle, SomethingCarriesEveryStoneThatMoved) {
  const SettleOptions options = on_soil(-4);
  const Stones before = random_balls(9);
  const Stones after = settled(before, options);
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].offset == before[i].offset) continue;
    const float r = radius_of(after[i]);
    float gap = after[i].offset.z() - r - (*options.soil - kBuried * 2 * r);
    for (std::size_t j = 0; j < after.size(); ++j) {
      const Vec3f from = after[i].offset - after[j].offset;
      if (j != i && from.z() > 0) gap = std::min(gap, from.norm() - r - radius_of(after[j]));
    }
    EXPECT_LT(gap, kCell) << i;
  }
}

TEST(Settle, StonesKeepTheirPlaceInThePacking) {
  Particles p = test::one_particle(Vec3::Constant(10), Vec3(5, 5, 5), 1);
  const Bed bed(p, balls(), {9, Vec2(1, 2)}, Vec2(10, 10), 4, {kCell, 0.5});
  BedPoint point;
  ASSERT_TRUE(bed.below(4, 3, point));
  EXPECT_NEAR(point.at.z(), 1, 0.05);  // it fell to the soil and is half buried there
  // The upper end of the particle at the place where the packing has it.
  EXPECT_NEAR((bed.in_packing(point) - Vec3f(5, 5, 6)).norm(), 0, 0.01f);
}

}  // namespace
}  // namespace terrazzo
