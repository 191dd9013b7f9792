// Level sets in OpenVDB files, and what is measured of them.
#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cmath>

#include "nodes/data/volume.h"
#include "nodes/export/formats/vdb_file.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using exporting::write_vdb;

// A sphere of 2 mm in voxels of 0.25 mm.
openvdb::FloatGrid::Ptr level_set_sphere(const char* name) {
  initialize_openvdb();
  const auto grid =
      openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(2, openvdb::Vec3f(0.1f, 0.2f, 0.3f), 0.25f);
  grid->setName(name);
  return grid;
}

double fraction_of(const Volume& volume, std::map<std::string, std::string> parameters = {}) {
  return test::run_node("Measure3D", {{"volume", Value::of(volume)}}, parameters)
      .metrics.at("voxel_fraction");
}

double expected_fraction(const openvdb::GridBase& grid) {
  const auto n = grid.evalActiveVoxelBoundingBox().dim();
  return 4.0 / 3 * M_PI * 8 / (n.x() * n.y() * n.z() * std::pow(0.25, 3));
}

TEST(LevelSets, AreMeasuredAsTheBodyInside) {
  const auto folder = test::temporary_folder();
  const auto grid = level_set_sphere("ls_sphere");
  write_vdb(folder / "a.vdb", {Vec3i::Zero(), {grid}}, "");
  const auto run = test::load_volume(folder / "a.vdb");
  EXPECT_TRUE(run.warnings.empty());
  const auto& volume = run.output<Volume>("volume");
  EXPECT_EQ(volume.grids[0]->getGridClass(), openvdb::GRID_LEVEL_SET);
  const double expected = expected_fraction(*grid);
  EXPECT_NEAR(fraction_of(volume), expected, 0.02 * expected);
  EXPECT_NEAR(fraction_of(volume, {{"phase", "binder"}}), 1 - expected, 0.02);
}

TEST(LevelSets, AreRecognizedWithoutTheirClass) {
  const auto folder = test::temporary_folder();
  const auto grid = level_set_sphere("distance");
  grid->setGridClass(openvdb::GRID_UNKNOWN);
  write_vdb(folder / "a.vdb", {Vec3i::Zero(), {grid}}, "");
  const auto run = test::load_volume(folder / "a.vdb");
  EXPECT_EQ(run.warnings.size(), 1u);
  const double expected = expected_fraction(*grid);
  EXPECT_NEAR(fraction_of(run.output<Volume>("volume")), expected, 0.02 * expected);
  // Not a level set: a density with a background, and one with negative values.
  auto density = openvdb::FloatGrid::create(1);
  density->setName("density");
  density->tree().setValue(openvdb::Coord(0), 0.5f);
  density->tree().setValue(openvdb::Coord(1), -0.5f);
  write_vdb(folder / "b.vdb", {Vec3i::Zero(), {density}}, "");
  const auto other = test::load_volume(folder / "b.vdb");
  EXPECT_EQ(other.output<Volume>("volume").grids[0]->getGridClass(), openvdb::GRID_UNKNOWN);
}

TEST(LevelSets, NamedDensityBecomeCoverage) {
  const auto folder = test::temporary_folder();
  const auto grid = level_set_sphere("density");
  write_vdb(folder / "a.vdb", {Vec3i::Zero(), {grid, level_set_sphere("other")}}, "");
  const auto run = test::load_volume(folder / "a.vdb");
  EXPECT_EQ(run.warnings.size(), 1u);
  const auto& volume = run.output<Volume>("volume");
  const auto density = volume.find<openvdb::FloatGrid>("density");
  EXPECT_EQ(density->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(density->background(), 0);
  EXPECT_EQ(density->tree().getValue(openvdb::Coord(0)), 1) << "inside, where the level set is inactive";
  EXPECT_EQ(volume.grids[1]->getGridClass(), openvdb::GRID_LEVEL_SET);
  const double expected = expected_fraction(*grid);
  EXPECT_NEAR(fraction_of(volume), expected, 0.02 * expected);
  double sum = 0;
  for (auto it = density->cbeginValueOn(); it; ++it) sum += *it * static_cast<double>(it.getVoxelCount());
  EXPECT_NEAR(sum * std::pow(0.25, 3), 4.0 / 3 * M_PI * 8, 0.2);
}

TEST(LevelSets, TheSharedSphere) {
  const fs::path path = test::shared_data() / "reports/levelset.vdb";
  if (!fs::exists(path)) GTEST_SKIP() << "no shared data";
  EXPECT_NEAR(fraction_of(test::load_volume(path).output<Volume>("volume")), 0.268, 0.002);
}

}  // namespace
}  // namespace terrazzo
