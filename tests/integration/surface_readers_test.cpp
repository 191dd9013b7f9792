// Surfaces of volumes, read by meshio.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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

}  // namespace
}  // namespace terrazzo
