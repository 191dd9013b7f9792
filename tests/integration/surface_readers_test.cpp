// Surfaces of volumes, read by meshio and filled by Gmsh.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/data/shapes.h"
#include "nodes/data/volume.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(ExportedSurfaces, OpenInMeshio) {
  if (!test::has_python_module("meshio")) GTEST_SKIP() << "python3-meshio is not installed";
  const fs::path out = test::temporary_folder();
  std::map<std::string, double> triangles;
  for (const char* path : {"a.msh", "a.stl"})
    triangles[path] =
        test::run_node("Export", {{"volume", Value::of(test::formula_volume())}}, {{"path", path}}, out)
            .metrics.at("triangles");
  const auto msh = test::run_reader("read_surface.py", {(out / "a.msh").string()});
  EXPECT_EQ(msh["types"], std::vector<std::string>{"triangle"});
  EXPECT_EQ(msh["triangles"], triangles["a.msh"]);
  const double edge[] = {1.5, 1.25, 1};  // 6 × 5 × 4 voxels of 0.25 mm
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(msh["low"][a], 0.125, 1e-12);
    EXPECT_NEAR(msh["high"][a], edge[a] + 0.125, 1e-12);
  }
  double sum = 0;
  for (const auto& [name, found] : msh["surfaces"].items()) {
    EXPECT_GT(found[0], 0) << name;
    EXPECT_EQ(found[1], 2) << name;
    sum += found[0].get<double>();
  }
  EXPECT_EQ(sum, triangles["a.msh"]);
  EXPECT_TRUE(msh["surfaces"].contains("BINDER-X0"));
  EXPECT_TRUE(msh["surfaces"].contains("PARTICLE_0-BINDER"));
  ASSERT_FALSE(msh["periodic"].empty());
  for (const auto& pair : msh["periodic"]) {
    int along = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(pair[2][a], pair[3][a]);
      if (pair[2][a] == 0) continue;
      ++along;
      EXPECT_EQ(pair[2][a], edge[a]);
    }
    EXPECT_EQ(along, 1);
  }
  const auto stl = test::run_reader("read_surface.py", {(out / "a.stl").string()});
  EXPECT_GT(stl["triangles"], 100);
  EXPECT_LT(stl["triangles"], triangles["a.stl"]);
}

// Gmsh fills the box with tetrahedra: no surfaces cross, and every region, of which some have several pieces,
// gets its part.
TEST(ExportedSurfaces, AreFilledByGmsh) {
  if (!test::has_program("gmsh")) GTEST_SKIP() << "gmsh is not installed";
  if (!test::has_python_module("meshio")) GTEST_SKIP() << "python3-meshio is not installed";
  const fs::path out = test::temporary_folder();
  const auto shapes = test::run_node("Shape", {}, {{"kind", "dodecahedron"}}).output<Shapes>("shapes");
  const auto sizes = test::run_node(
      "Distribution", {}, {{"kind", "uniform"}, {"min", "1"}, {"max", "2"}, {"volume_fraction", "0.4"}});
  const auto pack = test::run_node(
      "Anneal", {{"distribution", sizes.outputs.at("distribution")}, {"shapes", Value::of(shapes)}},
      {{"size", "5"}});
  const auto voxels =
      test::run_node("Voxelize", {{"particles", pack.outputs.at("particles")}, {"shapes", Value::of(shapes)}},
                     {{"resolution", "20"}});
  const auto run =
      test::run_node("Export", {{"volume", voxels.outputs.at("volume")}}, {{"path", "a b.msh"}}, out);
  const auto gmsh = test::run_command(
      {"/bin/sh", "-c", "cd '" + out.string() + "' && gmsh -3 -format msh2 -o tets.msh 'a b.geo'"});
  EXPECT_EQ(gmsh.exit_code, 0) << gmsh.out << gmsh.err;
  EXPECT_EQ(gmsh.out.find("Error"), std::string::npos) << gmsh.out;
  const auto tets = test::run_reader("read_surface.py", {(out / "tets.msh").string()});
  EXPECT_NEAR(tets["volume"], 125, 1e-6);
  EXPECT_GT(tets["least"], 0);
  std::size_t regions = 0;
  std::ifstream table(out / "a b.msh.csv");
  for (std::string line; std::getline(table, line);) ++regions;
  EXPECT_EQ(tets["regions"], regions - 1);  // less the line of names
  EXPECT_GT(regions, 20u);
}

}  // namespace
}  // namespace terrazzo
