// Voids, from the packing to the written files.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/color/colorize/colorize.h"
#include "nodes/data/profiles.h"
#include "nodes/data/volume.h"
#include "nodes/export/formats/gltf.h"
#include "nodes/packing/rigid/statistics.h"
#include "nodes/volumes/voxelize/voxelize.h"
#include "tests/nodes/packing/anneal/brute_force.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace colorize;
using namespace exporting;
using namespace voxelize;

using test::code_of;
using test::run_node;

struct Mixture {
  Shapes shapes = test::shapes_of({test::icosphere(2), test::cube()});
  SizeDistribution distribution = test::distribution(shapes, 1, 1.5, 0.5);
  Mixture() {
    auto whole = distribution.shapes.front();
    distribution.shapes.assign(2, whole);
    for (int k = 0; k < 2; ++k) {
      auto& e = distribution.shapes[k];
      e.shape = e.cls = k;
      for (auto* v : {&e.N_V, &e.low, &e.high})
        for (double& x : *v) x *= k ? 0.7 : 0.3;
    }
  }
  test::NodeRun pack(std::map<std::string, std::string> parameters) const {
    parameters.emplace("count", "150");
    return run_node(
        "Anneal",
        {{"shapes", Value::of<Shapes>(shapes)}, {"distribution", Value::of<SizeDistribution>(distribution)}},
        parameters, {}, 2);
  }
};

TEST(Voids, AClassIsPackedLikeOthersAndHasNoMatter) {
  const Mixture m;
  const auto run = m.pack({{"voids", "[1]"}}), plain = m.pack({});
  const auto& p = run.output<Particles>("particles");
  const auto& q = plain.output<Particles>("particles");
  ASSERT_EQ(p.count(), q.count());
  EXPECT_TRUE(q.voids.empty());
  double cubes = 0;
  for (std::size_t i = 0; i < p.count(); ++i) {
    EXPECT_EQ(p.is_void(i), p.shape[i] == 1);
    EXPECT_EQ(p.position[i], q.position[i]);  // voids do not affect the packing
    if (p.shape[i] == 1) cubes += std::pow(p.scale[i], 3);
    if (p.is_void(i)) {
      EXPECT_EQ(p.color[i], Vec3f(Vec3f::Zero()));
    }
  }
  EXPECT_GT(p.void_count(), 50u);
  EXPECT_LT(p.void_count(), p.count());
  EXPECT_NEAR(run.metrics.at("void_fraction"), cubes / p.box.prod(), 1e-12);
  EXPECT_EQ(plain.metrics.at("void_fraction"), 0);
  EXPECT_EQ(run.metrics.at("packing_fraction"), plain.metrics.at("packing_fraction"));
}

TEST(Voids, AllOfAFoamOrAClassThatThereIs) {
  const Mixture m;
  const auto run = m.pack({{"voids", "all"}});
  const auto& p = run.output<Particles>("particles");
  EXPECT_EQ(p.void_count(), p.count());
  EXPECT_NEAR(run.metrics.at("void_fraction"), run.metrics.at("packing_fraction"), 1e-12);
  EXPECT_EQ(code_of([&] { m.pack({{"voids", "[0, 2]"}}); }), "no-such-class");
}

TEST(Voids, WhatIsDroppedTakesItsMarkAlong) {
  Mixture m;
  for (auto& e : m.distribution.shapes)
    for (double& n : e.N_V) n *= 1.4;
  m.distribution.volume_fraction = 0.7;
  const auto run = m.pack({{"count", "60"}, {"voids", "[1]"}, {"on_jam", "drop"}, {"iterations", "60"}});
  const auto& p = run.output<Particles>("particles");
  EXPECT_GT(run.metrics.at("dropped"), 0);
  ASSERT_EQ(p.voids.size(), p.count());
  for (std::size_t i = 0; i < p.count(); ++i) EXPECT_EQ(p.is_void(i), p.shape[i] == 1);
}

// Two balls side by side, one of which is a void.
Particles pair_of_balls() {
  Particles p;
  p.box = Vec3::Constant(4);
  p.resize(2);
  p.position = {Vec3(1, 2, 0.2), Vec3(3, 2, 2)};  // the first one crosses the face of the box
  p.scale = {0.8, 0.9};
  p.size = {1.6, 1.8};
  p.color = {Vec3f::Zero(), Vec3f(0.8f, 0.2f, 0.1f)};
  p.voids = {1, 0};
  p.binder_color = Vec3f(0.1f, 0.3f, 0.5f);
  return p;
}

TEST(Voids, VoxelsOfVoidsAreNotDense) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const Particles p = pair_of_balls();
  VoxelReport report;
  const Volume v = voxelize::voxelize(p, shapes, nullptr, choose_lattice(p.box, {48}), report);
  const double volume = shapes.shapes[0].volume / 64;
  EXPECT_NEAR(report.exact_void_fraction, volume * std::pow(0.8, 3), 1e-9);
  EXPECT_NEAR(report.exact_volume_fraction, volume * std::pow(0.9, 3), 1e-9);
  EXPECT_NEAR(report.void_fraction, report.exact_void_fraction, 2e-3 * report.exact_void_fraction);
  EXPECT_NEAR(report.volume_fraction, report.exact_volume_fraction, 2e-3 * report.exact_volume_fraction);
  const auto voids = v.find<openvdb::FloatGrid>("void"), density = v.find<openvdb::FloatGrid>("density"),
             surface = v.find<openvdb::FloatGrid>("surface");
  const auto color = v.find<openvdb::Vec3SGrid>("Cd");
  ASSERT_TRUE(voids);
  const auto at = [](double x, double y, double z) {
    return openvdb::Coord(int(12 * x), int(12 * y), int(12 * z));
  };
  for (const auto& hole : {at(1, 2, 0.2), at(1, 2, 3.8)}) {
    EXPECT_EQ(voids->tree().getValue(hole), 1);
    EXPECT_EQ(density->tree().getValue(hole), 0);
    EXPECT_GT(surface->tree().getValue(hole), 0);
    EXPECT_EQ(color->tree().getValue(hole), color->background());  // the binder's, so that walls are not dark
    EXPECT_EQ(v.find<openvdb::Int32Grid>("id")->tree().getValue(hole), 0);
  }
  EXPECT_EQ(voids->tree().getValue(at(3, 2, 2)), 0);
  EXPECT_EQ(density->tree().getValue(at(3, 2, 2)), 1);
  Particles solid = p;
  solid.voids = {0, 0};
  EXPECT_FALSE(voxelize::voxelize(solid, shapes, nullptr, choose_lattice(p.box, {48}), report)
                   .find<openvdb::FloatGrid>("void"));
}

TEST(Voids, GltfHoldsMatterOnly) {
  const auto shapes = test::shapes_of({test::icosphere(1)});
  Particles p = pair_of_balls();
  const auto folder = test::temporary_folder();
  write_glb(folder / "one.glb", p, shapes);
  Particles one = p;
  one.resize(1);
  one.position = {p.position[1]};
  one.scale = {p.scale[1]};
  one.color = {p.color[1]};
  one.voids = {};
  write_glb(folder / "same.glb", one, shapes);
  EXPECT_EQ(std::filesystem::file_size(folder / "one.glb"), std::filesystem::file_size(folder / "same.glb"));
  p.voids = {1, 1};
  EXPECT_EQ(code_of([&] { write_glb(folder / "none.glb", p, shapes); }), "no-particles");
}

TEST(Voids, ColorsAreForMatter) {
  Particles p = pair_of_balls();
  Profiles seen;
  seen.profiles.resize(1);
  seen.profiles[0].area = 1;
  seen.profiles[0].weight = 1;
  seen.profiles[0].color = Vec3f(0, 1, 0);
  for (const auto mode : {ColorMode::Random, ColorMode::BySize, ColorMode::Classes}) {
    p.cls = {5, 0};  // the class of a void needs no profile
    colorize::colorize(p, seen, {mode, 1});
    EXPECT_EQ(p.color[0], Vec3f(Vec3f::Zero()));
    EXPECT_EQ(p.color[1], Vec3f(0, 1, 0));
    EXPECT_EQ(p.cls[0], 5);
  }
}

}  // namespace
}  // namespace terrazzo
