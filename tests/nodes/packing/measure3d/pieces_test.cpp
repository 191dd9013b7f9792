// Labels that mark phases instead of particles.
#include <gtest/gtest.h>

#include <algorithm>

#include "nodes/data/table.h"
#include "nodes/packing/measure3d/pieces.h"
#include "tests/nodes/packing/measure3d/blocks.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using measure3d::Phases;
using measure3d::Raster;
using measure3d::split_phases;

// Eight cubes of 4 voxels, one of which wraps around all sides of the box, in a matrix with the label 0.
std::int32_t cubes(int x, int y, int z, std::int32_t matrix) {
  const auto in = [](int v) { return (v + 1) % 8 < 4; };
  return in(x) && in(y) && in(z) ? 1 : matrix;
}

Raster raster(bool periodic, const test::LabelAt& label) {
  return test::raster_of(Vec3i::Constant(16), Vec3::Ones(), periodic, label);
}

TEST(Measure3DPieces, PiecesOfOneLabelWrapAroundThePeriodicBox) {
  Raster r = raster(true, [](int x, int y, int z) { return cubes(x, y, z, -1); });
  const Phases phases = split_phases(r, {});
  EXPECT_EQ(phases.labels, std::vector<std::int32_t>{1});
  EXPECT_EQ(phases.first, 2);
  EXPECT_EQ(phases.label_of, std::vector<std::int32_t>(8, 1));
  EXPECT_EQ(phases.spans, std::vector<char>(8, 0));
  EXPECT_EQ(r.ids[r.index(0, 0, 0)], r.ids[r.index(15, 15, 15)]);
  EXPECT_NE(r.ids[r.index(0, 0, 0)], r.ids[r.index(8, 0, 0)]);
  EXPECT_EQ(r.ids[r.index(4, 4, 4)], -1);
  // Without period, each of the cubes at the border is in several pieces.
  Raster open = raster(false, [](int x, int y, int z) { return cubes(x, y, z, -1); });
  EXPECT_EQ(split_phases(open, {}).label_of.size(), 27u);
}

TEST(Measure3DPieces, ParticlesStayWhatTheyAre) {
  const auto two = [](int x, int, int) { return x < 5 ? 3 : x < 9 ? 7 : -1; };
  Raster open = raster(false, two);
  EXPECT_TRUE(split_phases(open, {}).labels.empty());
  EXPECT_EQ(open.ids[0], 3);
  // A few voxels apart from the particle do not make it a phase.
  Raster stray = raster(true, [](int x, int y, int z) {
    return (x < 6 && y < 6 && z < 6) || (x == 9 && y == 9 && z % 4 == 0) ? 5 : -1;
  });
  EXPECT_TRUE(split_phases(stray, {}).labels.empty());
  EXPECT_EQ(stray.ids[stray.index(9, 9, 4)], 5);
}

TEST(Measure3DPieces, WhatReachesAcrossTheBoxIsAPhase) {
  Raster r = raster(true, [](int x, int y, int z) { return cubes(x, y, z, 0); });
  const Phases phases = split_phases(r, {});
  EXPECT_EQ(phases.labels, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(phases.label_of.size(), 9u);
  EXPECT_EQ(std::count(phases.spans.begin(), phases.spans.end(), 1), 1);
  EXPECT_EQ(phases.label_of[static_cast<std::size_t>(r.ids[r.index(4, 4, 4)] - phases.first)], 0);
}

// Two phases are no two particles, and one phase is not one.
TEST(Measure3DPieces, TheNodeMeasuresThePiecesOfPhases) {
  const Value volume = Value::of(test::label_volume(Vec3i::Constant(16), 0.5, true,
                                                    [](int x, int y, int z) { return cubes(x, y, z, 0); }));
  const auto run = test::run_node("Measure3D", {{"volume", volume}}, {});
  EXPECT_EQ(run.metrics.at("particles"), 8);
  const auto& t = run.output<Table>("particles");
  ASSERT_EQ(t.rows.size(), 9u);
  for (std::size_t k = 0; k < 9; ++k) {
    const bool matrix = t.number(k, "cut") == 1;
    EXPECT_EQ(t.number(k, "class"), matrix ? 0 : 1);
    EXPECT_NEAR(t.number(k, "volume mm³"), matrix ? 512 - 64 : 8, 1e-9);
  }
  EXPECT_TRUE(std::any_of(run.warnings.begin(), run.warnings.end(), [](const std::string& w) {
    return w.find("2 of the labels mark a phase instead of a particle (0, 1)") != std::string::npos;
  }));
  // A network alone has no particles at all.
  const Value network = Value::of(test::label_volume(
      Vec3i::Constant(16), 0.5, true, [](int x, int y, int z) { return cubes(x, y, z, 0) == 0 ? 1 : -1; }));
  const auto alone = test::run_node("Measure3D", {{"volume", network}}, {});
  EXPECT_EQ(alone.metrics.count("particles"), 0u);
  EXPECT_EQ(alone.metrics.count("nematic_order"), 0u);
  EXPECT_NEAR(alone.metrics.at("voxel_fraction"), 7.0 / 8, 1e-12);
}

}  // namespace
}  // namespace terrazzo
