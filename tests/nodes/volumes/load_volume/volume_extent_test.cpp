// The voxels of a volume are those that were given, not those that are active.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/volume.h"
#include "nodes/export/formats/vdb_file.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/run_node.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// A ball of particle 5 in the corner of an array of 12 × 10 × 8.
const Vec3i kGivenSize(12, 10, 8);
std::int32_t id_at(std::size_t i) {
  const auto n = static_cast<int>(i);
  return Vec3(n % 12 - 4.0, n / 12 % 10 - 4.0, n / 120 - 4.0).norm() < 3 ? 5 : -1;
}
std::size_t voxels_in_ball() {
  std::size_t n = 0;
  for (std::size_t i = 0; i < 960; ++i) n += id_at(i) >= 0;
  return n;
}

Volume ball_volume() {
  Volume v;
  add_id_grid(v, "id", kGivenSize, Vec3::Constant(0.5), {}, id_at);
  v.extent = kGivenSize;
  return v;
}

TEST(VolumeExtent, ComesBackFromTheCache) {
  Volume v = ball_volume();
  v.first = Vec3i(-3, 2, 1);
  v.extent = Vec3i(20, 30, 40);
  const auto bytes = test::bytes_of(v);
  Reader r(bytes.data(), bytes.size());
  const auto back = std::static_pointer_cast<const Volume>(value_type<Volume>().decode(r));
  EXPECT_EQ(back->first, v.first);
  EXPECT_EQ(back->extent, v.extent);
  EXPECT_EQ(back->resolution, Vec3i::Zero());
  EXPECT_EQ(test::bytes_of(*back), bytes);
  EXPECT_EQ(voxels_of(*back), openvdb::CoordBBox(openvdb::Coord(-3, 2, 1), openvdb::Coord(16, 31, 40)));
  Volume unknown = v;
  unknown.extent = unknown.first = Vec3i::Zero();
  EXPECT_NE(test::bytes_of(unknown), bytes);
  EXPECT_EQ(voxels_of(unknown), v.grids[0]->evalActiveVoxelBoundingBox());
}

TEST(VolumeExtent, IsWhatMeasure3dMeasures) {
  const auto run = test::run_node("Measure3D", {{"volume", Value::of(ball_volume())}}, {});
  EXPECT_NEAR(run.metrics.at("voxel_fraction"), static_cast<double>(voxels_in_ball()) / 960, 1e-12);
}

// Every format that Export writes voxels in, read back.
TEST(VolumeExtent, SurvivesFiles) {
  const auto folder = test::temporary_folder();
  for (const char* name : {"a.vdb", "a.vti", "a.dream3d", "a.npy", "a.nii"}) {
    test::run_node("Export", {{"volume", Value::of(ball_volume())}}, {{"path", name}, {"grids", "id"}},
                   folder);
    std::map<std::string, std::string> more = {{"grid", "id"}};
    if (std::string(name) == "a.npy") more["spacing"] = "0.5";
    if (std::string(name) == "a.nii") more["intercept"] = "-1";
    const auto run = test::load_volume(folder / name, more);
    const auto& back = run.output<Volume>("volume");
    EXPECT_EQ(back.extent, kGivenSize) << name;
    EXPECT_EQ(back.first, Vec3i::Zero()) << name;
    const auto id = back.find<openvdb::Int32Grid>("id");
    ASSERT_TRUE(id) << name;
    for (std::size_t i = 0; i < 960; ++i) {
      const auto n = static_cast<int>(i);
      ASSERT_EQ(id->tree().getValue(openvdb::Coord(n % 12, n / 12 % 10, n / 120)), id_at(i)) << name << i;
    }
  }
}

TEST(VolumeExtent, GivenIdsInANumpyArrayAreNotCropped) {
  const auto folder = test::temporary_folder();
  std::string header = "{'descr': '|i1', 'fortran_order': True, 'shape': (12, 10, 8), }";
  header.resize(118, ' ');
  std::string content = std::string("\x93NUMPY\1\0", 8) + static_cast<char>(118) + '\0' + header;
  for (std::size_t i = 0; i < 960; ++i) content += static_cast<char>(id_at(i));
  std::ofstream(folder / "a.npy", std::ios::binary) << content;
  const auto run = test::load_volume(folder / "a.npy", {{"spacing", "1"}, {"grid", "id"}});
  const VoxelBox box = voxel_box(run.output<Volume>("volume"));
  EXPECT_EQ(box.size, kGivenSize);
  EXPECT_EQ(box.first, Vec3i::Zero());
}

TEST(VolumeExtent, ThatDoesNotContainTheVoxelsIsIgnored) {
  const auto folder = test::temporary_folder();
  Volume v = ball_volume();
  v.extent = Vec3i(3, 3, 3);
  exporting::write_vdb(folder / "a.vdb", v, "");
  const auto run = test::load_volume(folder / "a.vdb");
  EXPECT_EQ(run.warnings.size(), 1u);
  EXPECT_FALSE(run.output<Volume>("volume").has_extent());
}

}  // namespace
}  // namespace terrazzo
