// Filling ends for any sizes: the effort is counted, the triangles are limited, and what was reached is kept.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/io/particles_json.h"
#include "nodes/packing/cells/fill_space.h"
#include "nodes/packing/cells/growth_shapes.h"
#include "nodes/packing/rigid/audit.h"
#include "nodes/packing/rigid/statistics.h"
#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {

using tessellation::FillOptions;
using tessellation::FillResult;
using tessellation::Method;

struct Stones {
  Shapes shapes = test::shapes_of({test::ellipsoid(2)});
  SizeDistribution distribution = test::distribution(shapes, 1, 4, 0.8);
  FillOptions options;
  explicit Stones(Method method) {
    options.method = method;
    options.population.count = 30;
    options.grains.roundness = 0.2;
    options.grains.least_gap = 0.45;
    // Without room for the round edges, the planes move in every round.
    if (method == Method::Grow) distribution = test::distribution(shapes, 1, 4, 0.93);
  }
  FillResult fill() const { return tessellation::fill_space(distribution, shapes, options); }
};

bool mentions(const std::vector<std::string>& notes, const std::string& text) {
  return std::any_of(notes.begin(), notes.end(),
                     [&](const std::string& n) { return n.find(text) != std::string::npos; });
}

TEST(FillEffort, OptionalWorkEndsWithTheEffort) {
  for (const Method method : {Method::Grow, Method::Laguerre}) {
    Stones stones(method);
    stones.options.corrections = 1;
    stones.options.effort = 1e300;
    const double whole = stones.fill().effort * 1e300;
    stones.options.effort = 0.05 * whole;
    const FillResult r = stones.fill();
    EXPECT_GT(r.effort, 1);  // it ended early, after the first steps that are always made
    EXPECT_LT(r.effort * stones.options.effort, whole);
    EXPECT_TRUE(mentions(r.notes, "more work than one node may do"));
    EXPECT_TRUE(mentions(r.notes, fmt::format("the mean by {:.2g}", r.mean_error)));
    EXPECT_GE(r.worst, r.mean_error);
    // What there is then is whole and sound.
    EXPECT_EQ(r.shapes.shapes.size(), r.particles.count());
    EXPECT_GT(r.fraction, 0.6);
    EXPECT_LT(packing::audit(r.shapes, r.particles).worst, 1e-4);
    for (std::size_t i = 0; i < r.particles.count(); ++i)
      EXPECT_NEAR(r.shapes.shapes[i].size(), r.particles.size[i], 1e-12);
  }
}

TEST(FillEffort, TheSameBitsForAnyNumberOfCallsThatEndEarly) {
  Stones stones(Method::Grow);
  stones.options.effort = 1e8;
  const FillResult a = stones.fill(), b = stones.fill();
  EXPECT_GT(a.effort, 1);
  EXPECT_EQ(test::bytes_of(a.particles), test::bytes_of(b.particles));
  EXPECT_EQ(a.effort, b.effort);
}

TEST(FillEffort, SmallParticlesGetFewerTrianglesAndManyGetFewerStill) {
  const Shapes shapes = test::shapes_of({test::icosphere(4)});
  Particles p;
  p.box = Vec3::Constant(100);
  p.resize(40);
  for (std::size_t i = 0; i < 40; ++i) p.size[i] = std::pow(1.1, double(i));
  tessellation::GrowthShapes fine, few;
  fine.prepare(shapes, p);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(&fine.of(i) == &fine.of(39), p.size[i] >= 0.5 * p.size[39]);
  const double most = 0.9 * static_cast<double>(fine.triangles());
  few.prepare(shapes, p, {}, most);
  EXPECT_LE(static_cast<double>(few.triangles()), most);
  EXPECT_EQ(few.of(39).mesh.triangles, fine.of(39).mesh.triangles);
  for (std::size_t i = 1; i < 40; ++i)
    EXPECT_LE(few.of(i - 1).mesh.triangles.size(), few.of(i).mesh.triangles.size());
  EXPECT_LT(fine.of(0).mesh.triangles.size(), fine.of(39).mesh.triangles.size());
}

// What is handed over if the filling is canceled at the first report of progress from `share` on.
struct HandedOver {
  int calls = 0;
  bool grown = false;
  Particles particles;
  Shapes shapes;

  HandedOver(Stones stones, double share) {
    std::atomic<bool> cancel{false};
    const Work::Report report = [&](double done, const std::string&) { cancel = cancel || done >= share; };
    stones.options.interrupted = [&](const Particles& p, const Shapes& s, bool whole) {
      ++calls, grown = whole, particles = p, shapes = s;
    };
    EXPECT_THROW(
        tessellation::fill_space(stones.distribution, stones.shapes, stones.options, Work(&cancel, &report)),
        Cancelled);
  }
  // Whether there is a shape with a volume for each particle, and its size is what the shape says.
  void expect_whole() const {
    ASSERT_EQ(calls, 1);
    EXPECT_GT(particles.count(), 20);
    for (std::size_t i = 0; i < particles.count(); ++i) {
      ASSERT_LT(static_cast<std::size_t>(particles.shape[i]), shapes.shapes.size());
      const Shape& s = shapes.shapes[particles.shape[i]];
      EXPECT_GT(mesh_volume(s.mesh), 0);
      EXPECT_NEAR(particles.scale[i] * s.size(), particles.size[i], 1e-9);
      EXPECT_GE(particles.position[i].minCoeff(), 0);
      EXPECT_GT((particles.box - particles.position[i]).minCoeff(), 0);
    }
  }
};

TEST(FillEffort, CanceledGrowthHandsOverThePacking) {
  Stones stones(Method::Grow);
  stones.options.corrections = 0;
  const HandedOver packed(stones, 0.5);
  packed.expect_whole();
  EXPECT_FALSE(packed.grown);
  EXPECT_EQ(packed.shapes.shapes.size(), stones.shapes.shapes.size());
  EXPECT_LT(packing::audit(packed.shapes, packed.particles).worst, 0.1);
  EXPECT_EQ(HandedOver(stones, 0).calls, 0);  // nothing is packed yet
}

TEST(FillEffort, CanceledFillingsHandOverTheLastComplete) {
  for (const Method method : {Method::Grow, Method::Laguerre}) {
    Stones stones(method);
    stones.options.corrections = 0;
    const HandedOver whole(stones, 0.9);  // while sizes are measured
    whole.expect_whole();
    EXPECT_TRUE(whole.grown);
    EXPECT_EQ(whole.shapes.shapes.size(), whole.particles.count());
    EXPECT_GT(packing::volume_fraction(whole.shapes, whole.particles), 0.75);
  }
  EXPECT_EQ(HandedOver(Stones(Method::Laguerre), 0.1).calls, 0);  // there are no cells yet
}

// Small grains between large ones keep their volume, since an automatic gap is never as wide as they are.
TEST(FillEffort, SmallGrainsKeepTheirVolumesBetweenJoints) {
  std::vector<double> volume;
  for (int k = 0; k < 60; ++k) volume.push_back(k < 12 ? 0.05 : 14);
  double total = 0;
  for (const double v : volume) total += v;
  tessellation::Effort effort;
  const auto grains =
      tessellation::laguerre_grains(Vec3::Constant(std::cbrt(total / 0.8)), volume, {}, effort);
  EXPECT_GT(grains.gap, 0);
  EXPECT_LT(grains.worst, 0.02);
}

TEST(FillEffort, AHandedOverResultCanBeLoaded) {
  Stones stones(Method::Laguerre);
  stones.options.corrections = 0;
  stones.options.population.count = 10;
  const FillResult r = stones.fill();
  const auto file = test::temporary_folder() / "fill.json";
  write_packing_json(file, r.particles, r.shapes);
  const auto particles = test::run_node("LoadParticles", {}, {{"path", file.string()}});
  EXPECT_EQ(test::bytes_of(particles.output<Particles>("particles")), test::bytes_of(r.particles));
  const auto shapes = test::run_node("LoadShapes", {}, {{"path", file.string()}});
  const auto& loaded = shapes.output<Shapes>("shapes").shapes;
  ASSERT_EQ(loaded.size(), r.shapes.shapes.size());
  for (std::size_t i = 0; i < loaded.size(); ++i) {
    EXPECT_EQ(loaded[i].mesh.vertices, r.shapes.shapes[i].mesh.vertices);
    EXPECT_EQ(loaded[i].mesh.triangles, r.shapes.shapes[i].mesh.triangles);
    EXPECT_EQ(loaded[i].volume, r.shapes.shapes[i].volume);
    EXPECT_EQ(loaded[i].name, r.shapes.shapes[i].name);
  }
}

}  // namespace
}  // namespace terrazzo
