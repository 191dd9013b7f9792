#include "nodes/packing/deposit/deposit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/convex_hull.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/packing/deposit/falling.h"
#include "nodes/packing/rigid/audit.h"
#include "runtime/random.h"
#include "tests/nodes/packing/anneal/packing_support.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace packing;

PopulationOptions bed_of(double wide, double deep, std::uint64_t seed) {
  PopulationOptions options;
  options.edges = {wide, wide, deep};
  options.seed = seed;
  return options;
}

Shapes balls() { return test::shapes_of({test::icosphere(3)}); }

PackResult bed_of_balls(std::uint64_t seed, double least = 1) {
  const Shapes shapes = balls();
  return deposit_particles(test::distribution(shapes, least, 2, 0.58), shapes, bed_of(10, 8, seed));
}

// The distance in the bed, which does not repeat upwards.
double distance(const Particles& p, std::size_t a, std::size_t b) {
  const Vec3 box(p.box.x(), p.box.y(), 1e9);
  return nearest_image(p.position[a] - p.position[b], box).norm();
}

TEST(Deposit, ABallLandsOnTheFloor) {
  const Shapes shapes = balls();
  FallingBodies bodies(Vec2(10, 10), 2);
  const FallingShape ball(shapes.shapes[0].mesh);
  ASSERT_GT(ball.radius, 0);
  bodies.add(ball, 2, Vec3(9.9, 5, 8), Quat::Identity());
  for (int k = 0; k < 300; ++k) bodies.step();
  EXPECT_NEAR(bodies.position(0).z(), 2 * ball.radius, 0.03 * ball.radius);
  EXPECT_NEAR(bodies.position(0).x(), 9.9, 0.1);
  EXPECT_LT(bodies.speed(), 0.01);
}

// Two balls meet across the border as they do in the middle.
TEST(Deposit, BodiesTouchAcrossTheBorder) {
  const Shapes shapes = balls();
  const FallingShape ball(shapes.shapes[0].mesh);
  for (const double shift : {0.0, 5.0, 9.0}) {
    FallingBodies bodies(Vec2(10, 10), 1);
    const auto at = [&](double x, double z) { return Vec3(std::fmod(x + shift, 10), 5, z); };
    bodies.add(ball, 1, at(0.55, ball.radius), Quat::Identity());
    bodies.add(ball, 1, at(1.55, ball.radius), Quat::Identity());
    bodies.add(ball, 1, at(1.1, 4), Quat::Identity());
    for (int k = 0; k < 400; ++k) bodies.step();
    Vec3 apart = nearest_image(bodies.position(2) - bodies.position(0), Vec3(10, 10, 1e9));
    EXPECT_GT(apart.norm(), 1.95 * ball.radius) << shift;
    apart = nearest_image(bodies.position(2) - bodies.position(1), Vec3(10, 10, 1e9));
    EXPECT_GT(apart.norm(), 1.95 * ball.radius) << shift;
  }
}

// With the few corners that Bullet is given, a stone is as large as it is.
TEST(Deposit, FallingShapesHaveTheirVolume) {
  const FallingShape shape(test::ellipsoid(3));
  ASSERT_EQ(shape.radius, 0);
  const Mesh hull = convex_hull(shape.corners);
  const double volume = mesh_volume(hull), truth = mesh_volume(test::ellipsoid(3));
  EXPECT_NEAR((volume + shape.margin * mesh_surface_area(hull)) / truth, 1, 0.02);
}

// In a box that is hardly wider than they are, bodies touch in every period.
TEST(Deposit, BodiesTouchInNarrowBoxes) {
  const FallingShape ball(balls().shapes[0].mesh);
  const double edge = 2.6 * ball.radius;
  FallingBodies bodies(Vec2(edge, edge), 1);
  for (int k = 0; k < 4; ++k)
    bodies.add(ball, 1, Vec3(0.1 * k, 0.2 * k, 1.5 + 2.2 * k) * ball.radius, Quat::Identity());
  for (int k = 0; k < 400; ++k) bodies.step();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) {
      const Vec3 apart = nearest_image(bodies.position(i) - bodies.position(j), Vec3(edge, edge, 1e9));
      EXPECT_GT(apart.norm(), 1.94 * ball.radius) << i << " " << j;
    }
}

TEST(Deposit, BallsLieAsDenseAsLooseOnesDo) {
  for (const std::uint64_t seed : {1, 2}) {
    const PackResult r = bed_of_balls(seed);
    const Particles& p = r.particles;
    ASSERT_GT(p.count(), 80u);
    // Of the lower half, where no air lies above stones and the floor matters little.
    double inside = 0;
    const double low = 1, high = 5;
    for (std::size_t i = 0; i < p.count(); ++i) {
      const double radius = p.size[i] / 2, z = p.position[i].z();
      const double a = std::clamp(low - z, -radius, radius), b = std::clamp(high - z, -radius, radius);
      inside += std::numbers::pi * (radius * radius * (b - a) - (b * b * b - a * a * a) / 3);
    }
    const double fraction = inside / (p.box.x() * p.box.y() * (high - low));
    EXPECT_GT(fraction, 0.52) << seed;  // from random loose to random close packing
    EXPECT_LT(fraction, 0.66) << seed;
    EXPECT_TRUE(r.notes.empty()) << r.notes.front();
  }
}

TEST(Deposit, EveryBallLiesOnOthersOrTheFloorAndOverlapsNone) {
  const Particles p = bed_of_balls(3, 0.7).particles;
  for (std::size_t i = 0; i < p.count(); ++i) {
    const double radius = p.size[i] / 2;
    EXPECT_GT(p.position[i].z(), 0.98 * radius) << i;
    EXPECT_LT(p.position[i].z() + 0.98 * radius, p.box.z()) << i;
    double gap = p.position[i].z() - radius;
    for (std::size_t j = 0; j < p.count(); ++j) {
      if (j == i) continue;
      const double apart = distance(p, i, j) - radius - p.size[j] / 2;
      EXPECT_GT(apart, -0.05 * std::min(p.size[i], p.size[j])) << i << " " << j;
      if (p.position[j].z() < p.position[i].z()) gap = std::min(gap, apart);
    }
    EXPECT_LT(gap, 0.1 * radius) << i;
  }
}

// Bullet's few corners are not the stones' surfaces.
TEST(Deposit, StonesOverlapLittle) {
  const Shapes shapes = test::shapes_of({test::ellipsoid(3)});
  const Particles p =
      deposit_particles(test::distribution(shapes, 1, 1.8, 0.58), shapes, bed_of(7, 6, 1)).particles;
  const AuditResult overlaps = audit(shapes, p);
  double mean = 0;
  for (const Penetration& o : overlaps.found) mean += o.relative / overlaps.found.size();
  EXPECT_LT(mean, 0.03);
  EXPECT_LT(overlaps.worst, 0.15);
  EXPECT_LT(overlaps.found.size(), 3 * p.count());  // of about seven contacts
}

TEST(Deposit, FlatStonesLieFlat) {
  Mesh plate = test::icosphere(3);
  for (Vec3& v : plate.vertices) v.z() *= 0.3;
  const Shapes shapes = test::shapes_of({plate});
  const auto r = deposit_particles(test::distribution(shapes, 1, 1.5, 0.55), shapes, bed_of(6, 4, 1));
  double upright = 0;
  for (const Quat& q : r.particles.orientation) upright += std::abs((q * Vec3::UnitZ()).z());
  EXPECT_GT(upright / r.particles.count(), 0.75);  // 0.5 if in any direction
}

// Also with other addresses, since Bullet's tree compares them.
TEST(Deposit, GivesTheSameBitsAgain) {
  const Particles a = bed_of_balls(4).particles;
  Particles b;
  std::thread([&] {
    std::vector<std::vector<char>> blocks;
    Random random(1, 2);
    for (int k = 0; k < 20000; ++k) blocks.emplace_back(16 + random.below(2000));
    for (std::size_t k = 0; k < blocks.size(); k += 1 + random.below(3)) blocks[k] = {};
    b = bed_of_balls(4).particles;
  }).join();
  EXPECT_EQ(a.position, b.position);
  EXPECT_NE(a.position, bed_of_balls(5).particles.position);
}

TEST(Deposit, CanBeCanceled) {
  std::atomic<bool> cancel = false;
  const Work::Report report = [&](double done, const std::string&) { cancel = done > 0.1; };
  const Shapes shapes = balls();
  EXPECT_THROW(deposit_particles(test::distribution(shapes, 1, 2, 0.58), shapes, bed_of(10, 8, 1),
                                 Work(&cancel, &report)),
               Cancelled);
}

TEST(Deposit, RefusesMoreThanCanFall) {
  const Shapes shapes = balls();
  EXPECT_EQ(test::code_of([&] {
              deposit_particles(test::distribution(shapes, 0.1, 0.11, 0.5), shapes, bed_of(8, 2, 1));
            }),
            "too-many-particles");
}

}  // namespace
}  // namespace terrazzo
