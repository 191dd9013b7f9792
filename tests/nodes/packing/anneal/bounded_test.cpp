// Packing ends after a bounded number of steps, for any shape and any requested density.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/packing/rigid/packing.h"
#include "nodes/packing/rigid/reachable.h"
#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {

using namespace packing;
using test::bytes_of;
using test::error_of;

Mesh needle() {
  return test::warped(test::cube(), [](const Vec3& p) { return Vec3(p.cwiseProduct(Vec3(0.2, 0.2, 1))); });
}

// Spikes in all directions, and sharp edges between them.
Mesh jagged() {
  return test::warped(test::icosphere(3), [](const Vec3& p) {
    return Vec3(p * (1 + 0.25 * std::sin(37 * p[0]) * std::sin(31 * p[1] + 1) * std::sin(29 * p[2] + 2)));
  });
}

Reachable estimate(const Shapes& shapes, double requested, std::int64_t count) {
  PopulationOptions o;
  o.count = count;
  const Population population = populate(test::distribution(shapes, 1, 1.2, requested), shapes, nullptr, o);
  std::vector<ContactShape> contact;
  for (const auto& s : shapes.shapes) contact.push_back(make_contact_shape(s.mesh));
  AnnealOptions options;
  options.steps = 1500;
  return try_sample(population, shapes, contact, options);
}

PackOptions jammed_options(std::int64_t count, OnJam on_jam, int iterations) {
  PackOptions o;
  o.population.count = count;
  o.on_jam = on_jam;
  o.iterations = iterations;
  return o;
}

// The volume fraction that the particles reach if they are packed without an estimate, because they are few.
double shrunk(const Shapes& shapes, std::int64_t count) {
  const PackOptions o = jammed_options(count, OnJam::Shrink, 1500);
  return volume_fraction(
      shapes, pack_particles(test::distribution(shapes, 1, 1.2, 0.9), shapes, nullptr, o).particles);
}

TEST(AnnealBounds, TheEstimateIsCloseToWhatIsReached) {
  for (const Mesh& mesh : {test::icosphere(2), test::cube(), needle()}) {
    const auto shapes = test::shapes_of({mesh});
    const Reachable few = estimate(shapes, 0.9, 600);
    EXPECT_TRUE(few.jammed);
    const double reached = shrunk(shapes, 500);
    EXPECT_NEAR(few.fraction, reached, 0.06);
  }
  const auto balls = test::shapes_of({test::icosphere(3)});
  EXPECT_NEAR(estimate(balls, 0.8, 600).fraction, 0.64, 0.02);
}

TEST(AnnealBounds, WhatCanBePackedIsNotEstimatedToJam) {
  const auto cubes = test::shapes_of({test::cube()});
  const Reachable r = estimate(cubes, 0.5, 600);
  EXPECT_FALSE(r.jammed);
  EXPECT_NEAR(r.fraction, 0.5, 0.01);
}

TEST(AnnealBounds, FewParticlesHaveNoEstimate) {
  EXPECT_EQ(estimate(test::shapes_of({test::cube()}), 0.9, 300).fraction, 0);
}

TEST(AnnealBounds, ShrinkAimsBelowTheEstimate) {
  const auto shapes = test::shapes_of({test::cube()});
  const auto d = test::distribution(shapes, 1, 1.3, 0.9);
  const PackOptions o = jammed_options(600, OnJam::Shrink, 1200);
  const PackResult r = pack_particles(d, shapes, nullptr, o);
  EXPECT_EQ(r.max_penetration, 0);
  EXPECT_GT(r.reachable, 0.55);
  const double reached = volume_fraction(shapes, r.particles);
  EXPECT_LT(reached, r.reachable);
  EXPECT_GT(reached, 0.94 * r.reachable);
  EXPECT_NEAR(reached, 0.9 * std::pow(r.shrink, 3), 0.01);
  EXPECT_EQ(test::brute::overlaps(shapes, r.particles), 0);
}

TEST(AnnealBounds, DropLeavesOutDownToTheEstimate) {
  const auto shapes = test::shapes_of({test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.9);
  const PackOptions o = jammed_options(600, OnJam::Drop, 1200);
  const PackResult r = pack_particles(d, shapes, nullptr, o);
  EXPECT_EQ(r.max_penetration, 0);
  EXPECT_EQ(r.shrink, 1);
  EXPECT_GT(r.dropped, 50u);
  EXPECT_GT(volume_fraction(shapes, r.particles), 0.9 * r.reachable);
  // All sizes remain: the mean changes little.
  const auto all = populate(d, shapes, nullptr, o.population).particles;
  const auto mean = [](const Particles& p) {
    double sum = 0;
    for (double s : p.size) sum += s;
    return sum / static_cast<double>(p.count());
  };
  EXPECT_NEAR(mean(r.particles), mean(all), 0.03);
  EXPECT_GE(*std::min_element(r.particles.size.begin(), r.particles.size.end()), 1);
}

TEST(AnnealBounds, JammedShapesEndWithinTheirSteps) {
  const auto shapes = test::shapes_of({jagged(), needle()});
  PackOptions o;
  o.population.count = 100;
  o.on_jam = OnJam::Shrink;
  o.iterations = 800;
  const PackResult r = pack_particles(test::distribution(shapes, 1, 3, 0.85), shapes, nullptr, o);
  EXPECT_LE(r.max_penetration, kTolerance);
  EXPECT_LT(r.shrink, 1);
  EXPECT_GT(r.iterations, 0);
  EXPECT_LT(r.steps, 2.5 * o.iterations);
  EXPECT_EQ(test::brute::overlaps(shapes, r.particles), 0);
}

TEST(AnnealBounds, MoreThanFullOfBallsShrinks) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  PackOptions o;
  o.population.count = 100;
  o.iterations = 800;
  const auto d = test::distribution(shapes, 1, 1.1, 0.95);
  EXPECT_EQ(error_of([&] { pack_particles(d, shapes, nullptr, o); }).substr(0, 18), "impossible-density");
  o.on_jam = OnJam::Shrink;
  EXPECT_GT(volume_fraction(shapes, pack_particles(d, shapes, nullptr, o).particles), 0.55);
}

TEST(AnnealBounds, FarTooDenseFailsEarly) {
  const auto shapes = test::shapes_of({needle()});
  PackOptions o;
  o.population.count = 600;
  o.iterations = 1000;
  const auto d = test::distribution(shapes, 1, 1.1, 0.9);
  const std::string what = error_of([&] { pack_particles(d, shapes, nullptr, o); });
  EXPECT_EQ(what.substr(0, 6), "jammed");
  EXPECT_NE(what.find("a sample of the particles"), std::string::npos) << what;
}

TEST(AnnealBounds, SameBitsForAnyNumberOfThreads) {
  const auto shapes = test::shapes_of({test::peanut(2), test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.9);
  for (const std::string on_jam : {"shrink", "drop"}) {
    const std::map<std::string, std::string> parameters{
        {"count", "600"}, {"on_jam", on_jam}, {"iterations", "120"}};
    const auto one = bytes_of(test::pack(shapes, d, parameters, 1).output<Particles>("particles"));
    for (const int threads : {2, 7})
      EXPECT_EQ(one, bytes_of(test::pack(shapes, d, parameters, threads).output<Particles>("particles")));
  }
}

TEST(AnnealBounds, ProgressIsLinearInTheWork) {
  Budget budget;
  budget.limit = 1000;
  budget.expected = 500;
  EXPECT_EQ(budget.progress(), 0);
  budget.used = 250;
  EXPECT_NEAR(budget.progress(), 0.45, 1e-12);
  budget.used = 500;
  EXPECT_NEAR(budget.progress(), 0.9, 1e-12);
  budget.used = 1000;
  EXPECT_NEAR(budget.progress(), 1, 1e-12);
  budget.used = 2000;
  EXPECT_EQ(budget.progress(), 1);
}

}  // namespace
}  // namespace terrazzo
