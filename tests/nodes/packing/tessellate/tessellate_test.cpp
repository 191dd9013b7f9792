// The node: volumes, contacts, gaps, orientations, threads.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/packing/cells/corner_roundness.h"
#include "nodes/packing/cells/laguerre.h"
#include "nodes/packing/rigid/audit.h"
#include "tests/nodes/packing/anneal/packing_support.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

using Settings = std::map<std::string, std::string>;

test::NodeRun tessellate(double fraction, Settings settings, int threads = 2, double largest = 1.6) {
  const Shapes shapes = test::shapes_of({test::ellipsoid(2)});
  const SizeDistribution d = test::distribution(shapes, 1, largest, fraction);
  return test::run_node(
      "Tessellate", {{"shapes", Value::of<Shapes>(shapes)}, {"distribution", Value::of<SizeDistribution>(d)}},
      settings, {}, threads);
}

// Sound whatever the method: closed meshes, measured shapes, no overlap, the fraction that was asked for.
void expect_sound_fill(const test::NodeRun& run, double fraction, double gap = 0, double tolerance = 0.003) {
  const auto& p = run.output<Particles>("particles");
  const auto& shapes = run.output<Shapes>("shapes");
  ASSERT_EQ(shapes.shapes.size(), p.count());
  double volume = 0;
  for (std::size_t i = 0; i < p.count(); ++i) {
    EXPECT_EQ(p.shape[i], int(i));
    EXPECT_EQ(p.scale[i], 1);
    const Shape& s = shapes.shapes[i];
    EXPECT_TRUE(mesh_faults(s.mesh).empty());
    EXPECT_NEAR(mesh_volume(s.mesh), s.volume, 1e-9 * s.volume);
    EXPECT_LT(mesh_centroid(s.mesh).norm(), 1e-6 * s.size());
    EXPECT_NEAR(s.size(), p.size[i], 1e-12);
    volume += s.volume;
    for (int a = 0; a < 3; ++a) EXPECT_TRUE(p.position[i][a] >= 0 && p.position[i][a] < p.box[a]);
  }
  EXPECT_NEAR(volume / p.box.prod(), fraction, tolerance);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), volume / p.box.prod(), 1e-9);
  EXPECT_LT(packing::audit(shapes, p, gap).worst, 1e-4);
}

TEST(Tessellate, LaguerreFillsTheBox) {
  for (const char* seed : {"1", "2"}) {
    const auto run = tessellate(0.9999999, {{"count", "80"}, {"seed", seed}, {"corrections", "0"}});
    expect_sound_fill(run, 1);
    EXPECT_LT(run.metrics.at("worst_volume_error"), 1e-3);
    EXPECT_EQ(run.metrics.at("gap"), 0);
  }
}

TEST(Tessellate, LaguerreLeavesTheBinder) {
  const auto run = tessellate(0.85, {{"count", "60"}, {"corrections", "0"}});
  const double gap = run.metrics.at("gap");
  EXPECT_GT(gap, 0.01);
  expect_sound_fill(run, 0.85, 0.999 * gap);  // every two grains are a gap apart
  EXPECT_GT(
      packing::audit(run.output<Shapes>("shapes"), run.output<Particles>("particles"), 1.05 * gap).worst,
      1e-4);
  EXPECT_LT(run.metrics.at("worst_volume_error"), 1e-3);
}

// Edges take no more of the binder than the least gap leaves them, and the volumes stay.
TEST(Tessellate, LaguerreRoundsEdgesAsFarAsJointsLeaveRoom) {
  const Vec3 box = Vec3::Constant(10);
  std::vector<double> volume;
  for (int k = 0; k < 60; ++k) volume.push_back(0.8 * 1000 / 60 * (1 + 0.4 * std::sin(k)));
  tessellation::LaguerreOptions options;
  tessellation::Effort effort;
  const auto sharp = tessellation::laguerre_grains(box, volume, options, effort);
  const double total = std::accumulate(volume.begin(), volume.end(), 0.0);
  options.least_gap = 0.5;
  for (const double wanted : {0.05, 0.9}) {
    options.roundness = wanted;
    const auto grains = tessellation::laguerre_grains(box, volume, options, effort);
    EXPECT_LE(grains.roundness, wanted);
    EXPECT_GT(grains.gap, 0.45 * sharp.gap);
    EXPECT_LT(grains.gap, sharp.gap);
    EXPECT_NEAR(std::accumulate(grains.volume.begin(), grains.volume.end(), 0.0) / total, 1, 2e-3);
    if (wanted == 0.05)
      EXPECT_EQ(grains.roundness, wanted);
    else
      EXPECT_LT(grains.gap, 0.6 * sharp.gap) << "as round as possible";
  }
  options.least_gap = 0;
  options.roundness = 0.9;
  EXPECT_EQ(tessellation::laguerre_grains(box, volume, options, effort).roundness, 0.9);
}

TEST(Tessellate, RoundedAndRoughGrainsDoNotOverlap) {
  expect_sound_fill(tessellate(0.8, {{"count", "40"}, {"roundness", "0.3"}, {"corrections", "0"}}), 0.8);
  const auto rough = tessellate(0.9, {{"count", "40"}, {"roughness", "0.04"}, {"corrections", "0"}});
  expect_sound_fill(rough, 0.9);
  const auto flat = tessellate(0.9, {{"count", "40"}, {"corrections", "0"}});
  double rough_area = 0, flat_area = 0;
  for (const Shape& s : rough.output<Shapes>("shapes").shapes) rough_area += s.surface_area;
  for (const Shape& s : flat.output<Shapes>("shapes").shapes) flat_area += s.surface_area;
  EXPECT_GT(rough_area, 1.02 * flat_area);
}

TEST(Tessellate, StretchedGrainsAreLonger) {
  const auto run = tessellate(0.999, {{"count", "150"}, {"stretch", "[2, 1, 1]"}, {"corrections", "0"}});
  expect_sound_fill(run, 0.999);
  Vec3 extent = Vec3::Zero();
  for (const Shape& s : run.output<Shapes>("shapes").shapes) {
    Eigen::AlignedBox3d box;
    for (const Vec3& v : s.mesh.vertices) box.extend(v);
    extent += box.sizes();
  }
  EXPECT_NEAR(extent[0] / extent[1], 2, 0.15);
  EXPECT_NEAR(extent[2] / extent[1], 1, 0.08);
}

TEST(Tessellate, GrowthReachesTheFraction) {
  for (const double fraction : {0.7, 0.85, 0.93}) {
    const auto run = tessellate(fraction, {{"count", "50"}, {"method", "grow"}, {"corrections", "0"}});
    expect_sound_fill(run, fraction, 0, fraction < 0.9 ? 0.003 : 0.01);  // at 0.93 some have no room
    EXPECT_LT(run.metrics.at("worst_volume_error"), fraction < 0.9 ? 0.02 : 0.2);
  }
}

TEST(Tessellate, GrowthKeepsTheGap) {
  const auto run =
      tessellate(0.75, {{"count", "80"}, {"method", "grow"}, {"gap", "0.04"}, {"corrections", "0"}});
  EXPECT_EQ(run.metrics.at("gap"), 0.04);
  const auto& p = run.output<Particles>("particles");
  EXPECT_LT(packing::audit(run.output<Shapes>("shapes"), p, 0.0399).worst, 1e-4);
  EXPECT_GT(packing::audit(run.output<Shapes>("shapes"), p, 0.05).worst, 1e-4);
}

// The roundness that sections of the grains show.
double shown_roundness(const test::NodeRun& run) {
  Profiles profiles;
  for (const auto& section :
       random_sections(run.output<Shapes>("shapes"), 400, {SectionKind::Random, 3, 0})) {
    Profile p;
    p.contour = section[0][0];
    profiles.profiles.push_back(p);
  }
  return tessellation::measure_roundness(profiles);
}

// Edges between flat contacts become round, volumes stay, and nothing overlaps.
TEST(Tessellate, GrowthRoundsEdgesAsFarAsThereIsRoom) {
  const Settings settings{{"count", "50"}, {"method", "grow"}, {"corrections", "0"}};
  for (const double fraction : {0.8, 0.9}) {
    double last = shown_roundness(tessellate(fraction, settings));
    for (const char* roundness : {"0.15", "0.3"}) {
      Settings round = settings;
      round["roundness"] = roundness;
      const auto run = tessellate(fraction, round);
      expect_sound_fill(run, fraction, 0, 0.01);
      EXPECT_LT(run.metrics.at("worst_volume_error"), fraction < 0.85 ? 0.02 : 0.2);
      EXPECT_LE(run.metrics.at("flat_contact"), 1);
      if (fraction < 0.85) {
        EXPECT_GT(shown_roundness(run), last) << roundness;
        last = shown_roundness(run);
      }
    }
  }
}

TEST(Tessellate, GrowthBelowPackingKeepsTheShapes) {
  const auto run = tessellate(0.3, {{"count", "60"}, {"method", "grow"}, {"corrections", "0"}});
  const Shapes given = test::shapes_of({test::ellipsoid(2)});
  const double roundness = std::cbrt(given.shapes[0].volume) / std::sqrt(given.shapes[0].surface_area);
  for (const Shape& s : run.output<Shapes>("shapes").shapes)
    EXPECT_NEAR(std::cbrt(s.volume) / std::sqrt(s.surface_area), roundness, 0.01 * roundness);
}

TEST(Tessellate, GrowthSimplifiesFineShapes) {
  const Shapes shapes = test::shapes_of({test::ellipsoid(4)});
  ASSERT_GT(shapes.shapes[0].mesh.triangles.size(), 5000u);
  const SizeDistribution d = test::distribution(shapes, 1, 1.6, 0.7);
  const auto run = test::run_node(
      "Tessellate", {{"shapes", Value::of<Shapes>(shapes)}, {"distribution", Value::of<SizeDistribution>(d)}},
      {{"count", "40"}, {"method", "grow"}, {"corrections", "0"}}, {}, 2);
  expect_sound_fill(run, 0.7);
  for (const Shape& s : run.output<Shapes>("shapes").shapes) EXPECT_LT(s.mesh.triangles.size(), 3000u);
}

TEST(Tessellate, CrystalAxesDoNotMoveGrains) {
  const auto plain = tessellate(0.9, {{"count", "50"}, {"corrections", "0"}});
  const auto uniform = tessellate(0.9, {{"count", "50"}, {"corrections", "0"}, {"crystal_axes", "uniform"}});
  const auto fiber = tessellate(
      0.9, {{"count", "50"}, {"corrections", "0"}, {"crystal_axes", "fiber"}, {"fiber_spread", "5"}});
  const auto& a = plain.output<Particles>("particles");
  double tilt = 0, mean = 0;
  for (const auto* run : {&uniform, &fiber}) {
    const auto& b = run->output<Particles>("particles");
    for (std::size_t i = 0; i < a.count(); ++i) {
      const Mesh &m = plain.output<Shapes>("shapes").shapes[i].mesh,
                 &n = run->output<Shapes>("shapes").shapes[i].mesh;
      EXPECT_LT((a.position[i] - b.position[i]).norm(), 1e-9);
      for (std::size_t v = 0; v < m.vertices.size(); ++v)
        EXPECT_LT((m.vertices[v] - b.orientation[i] * n.vertices[v]).norm(), 1e-9);
      const double z = (b.orientation[i] * Vec3::UnitZ()).z();
      if (run == &fiber)
        tilt += std::pow(std::acos(std::clamp(z, -1.0, 1.0)), 2) / double(a.count());
      else
        mean += z / double(a.count());
    }
  }
  // The tilt of a fiber has a Rayleigh distribution: its mean square is twice the variance.
  EXPECT_NEAR(std::sqrt(tilt / 2) * 180 / 3.14159265, 5, 1.5);
  EXPECT_LT(std::abs(mean), 4 / std::sqrt(3.0 * double(a.count())));
}

TEST(Tessellate, SameBitsForAnyNumberOfThreads) {
  for (const Settings& settings : {Settings{{"count", "30"},
                                            {"corrections", "1"},
                                            {"roundness", "0.1"},
                                            {"roughness", "0.02"},
                                            {"gap_variation", "0.5"}},
                                   Settings{{"count", "30"},
                                            {"corrections", "1"},
                                            {"method", "grow"},
                                            {"gap", "0.02"},
                                            {"crystal_axes", "fiber"}}}) {
    const auto one = tessellate(0.85, settings, 1);
    for (int threads : {2, 7}) {
      const auto many = tessellate(0.85, settings, threads);
      EXPECT_EQ(test::bytes_of(one.output<Particles>("particles")),
                test::bytes_of(many.output<Particles>("particles")));
      for (std::size_t i = 0; i < one.output<Shapes>("shapes").shapes.size(); ++i)
        EXPECT_EQ(one.output<Shapes>("shapes").shapes[i].mesh.vertices,
                  many.output<Shapes>("shapes").shapes[i].mesh.vertices);
    }
  }
}

TEST(Tessellate, FewParticles) {
  for (const char* count : {"1", "2", "5"}) {
    const auto run = tessellate(0.9, {{"count", count}, {"corrections", "0"}}, 2, 1.1);
    EXPECT_GE(run.output<Particles>("particles").count(), 1u);
    expect_sound_fill(run, 0.9);
  }
}

TEST(Tessellate, Errors) {
  EXPECT_EQ(test::code_of([] { tessellate(0.9, {{"stretch", "[1, 2]"}}); }), "bad-stretch");
  EXPECT_EQ(test::code_of([] { tessellate(0.9, {{"count", "50"}, {"gap", "5"}}); }), "gap-too-wide");
}

}  // namespace
}  // namespace terrazzo
