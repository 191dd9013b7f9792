#include "nodes/packing/rigid/population/clusters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/packing/rigid/placement.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

Profile disc(const Vec2& center, double size) {
  Profile p;
  p.area = std::numbers::pi / 4 * size * size;
  p.centroid = center;
  for (int k = 0; k < 24; ++k) {
    const double at = k * std::numbers::pi / 12;
    p.contour.push_back(center + 0.5 * size * Vec2(std::cos(at), std::sin(at)));
  }
  return p;
}

// A section of balls of 0.1 mm in 20 mm: the pair correlation in it is that in space.
Profiles section_of(const Packing& packing) {
  Profiles out;
  out.window = Vec2(20, 20);
  out.observed_area = 400;
  for (std::size_t i = 0; i < packing.count(); ++i)
    if (std::abs(packing.position[i].z() - 10) < 0.2)
      out.profiles.push_back(disc(packing.position[i].head<2>(), 0.1));
  return out;
}

Packing balls(std::size_t n) {
  Packing p;
  p.box = Vec3::Constant(20);
  p.shape.assign(n, 0);
  p.scale.assign(n, 1);
  p.size.assign(n, 0.1);
  p.position.resize(n);
  p.orientation.resize(n);
  return p;
}

TEST(Clusters, AreFoundAsTheyWerePlaced) {
  const Clusters truth{0.5, 0.4, 8};
  Packing packing = balls(20000);
  place_at_random(packing, 0, std::vector<double>(packing.count(), 0.05), 3, {}, truth);
  const Clusters found = measure_clusters(section_of(packing));
  EXPECT_GT(found.below, 0);
  EXPECT_NEAR(found.spread, truth.spread, 0.25 * truth.spread);
  EXPECT_NEAR(found.excess, truth.excess, 0.4 * truth.excess);
}

TEST(Clusters, AreNotFoundInRandomPlaces) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Packing packing = balls(5000);
    place_at_random(packing, 0, std::vector<double>(packing.count(), 0.05), seed, {});
    EXPECT_EQ(measure_clusters(section_of(packing)).below, 0) << seed;
  }
}

// Small particles that keep out of large ones are no clusters.
TEST(Clusters, AreNotWhatLargeParticlesLeave) {
  Profiles profiles;
  profiles.window = Vec2(20, 20);
  Random random(1);
  for (int k = 0; k < 16; ++k)
    profiles.profiles.push_back(disc(Vec2(2.5 + 5 * (k % 4), 2.5 + 5 * (k / 4)), 4.8));
  while (profiles.profiles.size() < 216) {
    const Vec2 p(20 * random.uniform(), 20 * random.uniform());
    bool free = true;
    for (int k = 0; k < 16; ++k) free = free && (profiles.profiles[k].centroid - p).norm() > 2.4;
    if (free) profiles.profiles.push_back(disc(p, 0.1));
  }
  EXPECT_EQ(measure_clusters(profiles).below, 0);
}

TEST(Clusters, NeedProfilesOfASection) {
  EXPECT_EQ(measure_clusters({}).below, 0);
  Packing packing = balls(20000);
  place_at_random(packing, 0, std::vector<double>(packing.count(), 0.05), 3, {}, {0.5, 0.4, 8});
  Profiles profiles = section_of(packing);
  profiles.view = View::Surface;
  EXPECT_EQ(measure_clusters(profiles).below, 0);
}

}  // namespace
}  // namespace terrazzo::packing
