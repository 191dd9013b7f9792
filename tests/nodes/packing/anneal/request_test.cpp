// Requests to the packer: sizes, volume fractions, on_jam, and invalid input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/packing/rigid/limits.h"
#include "nodes/packing/rigid/population/population.h"
#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {

using test::bytes_of;
using test::error_of;
using test::pack;
using test::brute::overlaps;

TEST(Anneal, SizesAreTheRequestedOnes) {
  const auto shapes = test::shapes_of({test::icosphere(2)});
  const auto d = test::distribution(shapes, 1, 3, 0.35, 8);
  const auto run = pack(shapes, d, {{"count", "400"}});
  const auto& sizes = run.output<Table>("sizes");
  const auto& p = run.output<Particles>("particles");
  for (std::size_t k = 0; k < d.classes(); ++k) {
    const double asked = d.shapes[0].N_V[k] * p.box.prod();
    EXPECT_NEAR(sizes.number(k, "requested"), asked, 0.05 * asked);
    const auto in_class = std::count_if(p.size.begin(), p.size.end(), [&](double s) {
      return s >= d.class_edges[k] && s < d.class_edges[k + 1];
    });
    EXPECT_NEAR(static_cast<double>(in_class), asked, 1.0 + 0.05 * asked);
  }
  EXPECT_EQ(run.metrics.at("shrink"), 1);
  EXPECT_EQ(run.metrics.at("dropped"), 0);
}

// As in the study of 2008: 4,000 particles of 0.125 mm³ in 1,000 mm³, whatever the shapes and their shares.
TEST(Anneal, ParticlesOfOneVolumeAreAsManyAsRequested) {
  auto shapes = test::shapes_of({test::icosphere(2), test::icosphere(1), test::icosphere(0)});
  const double shares[] = {0.6171, 0.2713, 0.1116};
  for (std::size_t i = 0; i < 3; ++i) {
    auto& s = shapes.shapes[i];
    for (auto& v : s.mesh.vertices) v.x() *= 1 + 0.7 * static_cast<double>(i);
    s = measure_shape(s.name, s.mesh, shares[i], Work());
  }
  for (const double fraction : {0.5, 0.4375}) {
    const auto d = test::run_node(
        "Distribution", {{"shapes", Value::of<Shapes>(shapes)}},
        {{"kind", "equal_volume"}, {"volume", "0.125"}, {"volume_fraction", std::to_string(fraction)}});
    packing::PopulationOptions options;
    options.edges = {10};
    const auto all = packing::populate(d.output<SizeDistribution>("distribution"), shapes, nullptr, options);
    ASSERT_EQ(all.particles.count(), static_cast<std::size_t>(8000 * fraction));
    double least = 1e9, most = 0;
    for (std::size_t i = 0; i < all.particles.count(); ++i) {
      const Shape& s = shapes.shapes[static_cast<std::size_t>(all.particles.shape[i])];
      const double v = s.volume * std::pow(all.particles.size[i] / s.size(), 3);
      least = std::min(least, v);
      most = std::max(most, v);
    }
    EXPECT_NEAR(least, 0.125, 1e-6);
    EXPECT_NEAR(most, 0.125, 1e-6);
  }
}

TEST(Anneal, JamNamesTheFractionReached) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto d = test::distribution(shapes, 1, 1.1, 0.75);
  const std::string what = error_of([&] { pack(shapes, d, {{"count", "100"}, {"iterations", "800"}}); });
  EXPECT_EQ(what.substr(0, 6), "jammed");
  EXPECT_NE(what.find("0.750 was requested"), std::string::npos);
  EXPECT_NE(what.find("volume fraction of 0.6"), std::string::npos) << what;
}

TEST(Anneal, ShrinkFreesAndReports) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto d = test::distribution(shapes, 1, 1.1, 0.8);
  const auto run = pack(shapes, d, {{"count", "100"}, {"on_jam", "shrink"}, {"iterations", "800"}});
  EXPECT_EQ(overlaps(shapes, run.output<Particles>("particles")), 0);
  EXPECT_LT(run.metrics.at("shrink"), 1);
  EXPECT_GT(run.metrics.at("packing_fraction"), 0.58);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), 0.8 * std::pow(run.metrics.at("shrink"), 3), 0.01);
  EXPECT_EQ(run.warnings.size(), 1u);
}

TEST(Anneal, DropFreesAndReports) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto d = test::distribution(shapes, 1, 1.1, 0.7);
  const auto run = pack(shapes, d, {{"count", "100"}, {"on_jam", "drop"}, {"iterations", "600"}});
  const auto& p = run.output<Particles>("particles");
  EXPECT_EQ(overlaps(shapes, p), 0);
  EXPECT_GT(run.metrics.at("dropped"), 0);
  EXPECT_EQ(run.metrics.at("shrink"), 1);
  EXPECT_GE(*std::min_element(p.size.begin(), p.size.end()), 1);
  EXPECT_GT(run.metrics.at("packing_fraction"), 0.5);
  EXPECT_EQ(run.warnings.size(), 1u);
}

TEST(Anneal, StartIsKeptAsItIs) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const auto d = test::distribution(shapes, 1, 2, 0.4);
  const auto first = pack(shapes, d, {{"size", "9"}});
  const auto& p = first.output<Particles>("particles");
  const auto again = pack(shapes, d, {{"size", "9"}, {"seed", "5"}}, 2, &p);
  EXPECT_EQ(again.metrics.at("kept"), static_cast<double>(p.count()));
  EXPECT_EQ(bytes_of(p), bytes_of(again.output<Particles>("particles")));

  auto more = d;
  more.shapes[0].N_V[0] *= 1.5;
  more.volume_fraction = 0;
  const auto added = pack(shapes, more, {{"size", "9"}}, 2, &p);
  EXPECT_EQ(added.metrics.at("kept"), static_cast<double>(p.count()));
  EXPECT_GT(added.output<Particles>("particles").count(), p.count());
  EXPECT_EQ(overlaps(shapes, added.output<Particles>("particles")), 0);
}

TEST(Anneal, VolumeFractionHoldsWhereShapesDisagree) {
  const auto shapes = test::shapes_of({test::cube()});
  auto d = test::distribution(shapes, 1, 1.2, 0.3);
  d.volume_fraction = 0.4;
  const auto run = pack(shapes, d, {{"count", "200"}});
  EXPECT_NEAR(run.metrics.at("packing_fraction"), 0.4, 0.004);
  EXPECT_EQ(run.warnings.size(), 1u);
  EXPECT_NEAR(
      pack(shapes, d, {{"count", "200"}, {"conserve", "number_density"}}).metrics.at("packing_fraction"), 0.3,
      0.003);
}

TEST(Anneal, BadInput) {
  const auto shapes = test::shapes_of({test::cube()});
  auto d = test::distribution(shapes, 1, 2, 0.3);
  const auto code = [&](const std::map<std::string, std::string>& parameters) {
    const std::string what = error_of([&] { pack(shapes, d, parameters); });
    return what.substr(0, what.find(':'));
  };
  EXPECT_EQ(code({{"size", "1.5"}}), "box-too-small");
  EXPECT_EQ(code({{"size", "1000"}}), "too-many-particles");
  EXPECT_EQ(code({{"binder_gap", "2"}, {"count", "200"}}), "impossible-density");
  EXPECT_EQ(code({{"size", "[10, 1.2, 10]"}}), "box-too-small");
  auto open = shapes;
  open.shapes[0].mesh.triangles.pop_back();
  EXPECT_EQ(error_of([&] { pack(open, d, {}); }).substr(0, 9), "open-mesh");
  auto good = d;
  for (auto& n : d.shapes[0].N_V) n = 0;
  EXPECT_EQ(code({}), "no-particles");
  d.shapes[0].N_V[1] = std::nan("");
  EXPECT_EQ(code({}), "bad-distribution");
  d = good;
  d.shapes[0].shape = 3;
  EXPECT_EQ(code({}), "bad-distribution");
  d = good;
  d.shapes.clear();
  EXPECT_EQ(code({}), "no-particles");
  d = good;
  d.volume_fraction = 1.2;
  EXPECT_EQ(code({}), "impossible-density");
  d = good;
  for (auto& n : d.shapes[0].N_V) n *= 1e-6;
  d.volume_fraction = 0;
  EXPECT_EQ(code({{"size", "3"}}), "no-particles");
}

TEST(Anneal, AsManyAsAreAllowed) {
  const auto shapes = test::shapes_of({test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.3);
  packing::PopulationOptions o;
  for (std::int64_t most = 100; most < 140; ++most) {
    o.count = o.most = most;
    EXPECT_NEAR(static_cast<double>(packing::populate(d, shapes, nullptr, o).particles.count()),
                static_cast<double>(most), 2);
    o.most = most - 1;
    EXPECT_THROW(packing::populate(d, shapes, nullptr, o), Error);
  }
}

TEST(Anneal, MoreThanTheMemoryHoldsIsRefusedBeforeTheWork) {
  const auto shapes = test::shapes_of({test::cube()});
  packing::PopulationOptions o;
  o.count = 1000;
  const auto population = packing::populate(test::distribution(shapes, 1, 1.2, 0.3), shapes, nullptr, o);
  const auto needed = static_cast<std::uint64_t>(packing::memory_needed(population, shapes));
  EXPECT_EQ(error_of([&] { packing::refuse_what_memory_cannot_hold(population, shapes, 2 * needed); }),
            "no error");
  EXPECT_TRUE(error_of([&] {
                packing::refuse_what_memory_cannot_hold(population, shapes, needed);
              }).starts_with("not-enough-memory"));
}

}  // namespace
}  // namespace terrazzo
