// Automatic boxes hold few enough particles for any range of sizes, and what differs from the request is
// said.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/packing/rigid/population/population.h"
#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {

using packing::populate;
using packing::Population;
using packing::PopulationOptions;

// Equal volumes in geometric classes from 1 to `range` mm.
SizeDistribution wide(double range, double fraction) {
  constexpr int kClasses = 12;
  SizeDistribution d;
  for (int k = 0; k <= kClasses; ++k) d.class_edges.push_back(std::pow(range, double(k) / kClasses));
  std::vector<double> density;
  for (int k = 0; k < kClasses; ++k) density.push_back(std::pow(d.class_edges[std::size_t(k)], -3));
  d.shapes = {{-1, 0, density, std::vector<double>(kClasses, 0), std::vector<double>(kClasses, 0)}};
  d.volume_fraction = fraction;
  return d;
}

bool mentions(const std::vector<std::string>& notes, const std::string& text) {
  return std::any_of(notes.begin(), notes.end(),
                     [&](const std::string& n) { return n.find(text) != std::string::npos; });
}

TEST(BoundedBox, HoldsAtMostFiveThousandParticlesUnlessMoreAreAskedFor) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  for (const double range : {2.0, 10.0, 35.0, 200.0, 3000.0}) {
    const Population p = populate(wide(range, 0.6), shapes, nullptr, {});
    EXPECT_LE(p.particles.count(), 5100u) << range;
    EXPECT_GT(p.particles.count(), p.left_out_fraction > 0 ? 4900u : 1800u) << range;
    EXPECT_GT(p.particles.box[0], 1.4 * range);
    EXPECT_NEAR(p.requested_fraction, 0.6, 1e-9);
    EXPECT_NEAR(p.target_fraction + p.left_out_fraction, 0.6, 1e-9);
    EXPECT_NEAR(p.fraction, p.target_fraction, 0.01) << range;
    // The largest ones are never left out.
    EXPECT_GT(*std::max_element(p.particles.size.begin(), p.particles.size.end()), 0.5 * range);
  }
}

TEST(BoundedBox, TheSmallestParticlesAreLeftToTheBinderAndNamed) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const SizeDistribution d = wide(60, 0.6);
  const Population few = populate(d, shapes, nullptr, {});
  EXPECT_GT(few.left_out_fraction, 0);
  EXPECT_TRUE(mentions(few.notes, "are left to the binder"));
  // Larger ones keep their proportions; of the class below, as many as there is room for stay.
  const auto& asked = d.shapes[0].N_V;
  const double scale = few.expected.back() / asked.back();
  for (std::size_t k = 0; k < asked.size(); ++k)
    if (d.class_edges[k + 1] > few.left_out_size * (1 + 1e-9))
      EXPECT_NEAR(few.expected[k], scale * asked[k], 1e-6 * scale * asked[k]) << k;
    else if (d.class_edges[k + 1] < few.left_out_size * (1 - 1e-9))
      EXPECT_EQ(few.expected[k], 0) << k;
    else
      EXPECT_LT(few.expected[k], scale * asked[k]) << k;
  PopulationOptions more;
  more.count = 100000;
  EXPECT_EQ(populate(d, shapes, nullptr, more).left_out_fraction, 0);
  PopulationOptions given;  // a box that the user chose holds all of them
  given.edges = {90};
  const Population all = populate(d, shapes, nullptr, given);
  EXPECT_EQ(all.left_out_fraction, 0);
  EXPECT_GT(all.particles.count(), 4100u);
}

TEST(BoundedBox, ACountThatTheBoxCannotKeepIsSaid) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const auto d = test::distribution(shapes, 1, 2.5, 0.3);
  const auto kept = test::pack(shapes, d, {{"count", "400"}});
  EXPECT_EQ(kept.metrics.at("requested_count"), 400);
  EXPECT_NEAR(kept.metrics.at("particles"), 400, 40);
  EXPECT_TRUE(kept.warnings.empty());
  const auto enlarged = test::pack(shapes, d, {{"count", "20"}});
  EXPECT_EQ(enlarged.metrics.at("requested_count"), 20);
  EXPECT_GT(enlarged.metrics.at("particles"), 25);
  EXPECT_TRUE(mentions(enlarged.warnings, "`count` asks for 20"));
  const auto given = test::pack(shapes, d, {{"count", "20"}, {"size", "8"}});
  EXPECT_EQ(given.metrics.count("requested_count"), 0u);
  EXPECT_FALSE(mentions(given.warnings, "count"));
}

// Few particles cannot have any volume fraction.
TEST(BoundedBox, AFractionThatIsNotReachedIsSaid) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  auto d = test::distribution(shapes, 1, 1.0001, 0.3);
  const auto run = test::pack(shapes, d, {{"size", "1.6"}});
  EXPECT_NE(run.metrics.at("packing_fraction"), run.metrics.at("requested_fraction"));
  EXPECT_TRUE(mentions(run.warnings, "0.300 was requested"));
}

}  // namespace
}  // namespace terrazzo
