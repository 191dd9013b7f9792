// DREAM3D files: what reads back through LoadVolume, what is refused, and damaged ones.
#include "nodes/export/formats/solvers/dream3d_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "nodes/common/io/hdf5/hdf5_input.h"
#include "nodes/common/io/provenance.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/dream3d.h"
#include "tests/nodes/export/export_support.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

fs::path dream3d_of(const Volume& v, std::map<std::string, std::string> parameters = {}) {
  const fs::path out = test::temporary_folder();
  parameters["path"] = "a b.dream3d";
  test::run_node("Export", {{"volume", Value::of(v)}}, parameters, out);
  return out / "a b.dream3d";
}

Volume loaded_dream3d(const fs::path& file, const std::string& grid = "") {
  return test::run_node("LoadVolume", {}, {{"path", file.string()}, {"grid", grid.empty() ? "\"\"" : grid}})
      .output<Volume>("volume");
}

TEST(ExportDream3d, CellsAreCompressed) {
  Volume v = test::formula_volume();
  v.resolution = Vec3i(40, 50, 60);
  const fs::path small = dream3d_of(v), large = dream3d_of(v, {{"compression", "none"}});
  EXPECT_LT(4 * fs::file_size(small), fs::file_size(large));
  const Volume a = loaded_dream3d(small, "density"), b = loaded_dream3d(large, "density");
  for (int z = 0; z < 60; ++z)
    for (int y = 0; y < 50; y += 7)
      for (int x = 0; x < 40; ++x) {
        const openvdb::Coord at(x, y, z);
        const float value = x < 6 && y < 5 && z < 4 ? test::formula_density(x, y, z) : 0;
        ASSERT_EQ(a.find<openvdb::FloatGrid>("density")->tree().getValue(at), value);
        ASSERT_EQ(b.find<openvdb::FloatGrid>("density")->tree().getValue(at), value);
      }
}

TEST(ExportDream3d, ReadsBackAsTheSameVolume) {
  const Volume v = test::formula_volume();
  const fs::path file = dream3d_of(v);
  const Volume back = loaded_dream3d(file);
  EXPECT_EQ(back.resolution, v.resolution);
  ASSERT_EQ(back.grids.size(), 4u);  // FeatureIds and Phases come from id
  const auto id = back.find<openvdb::Int32Grid>("id");
  const auto density = back.find<openvdb::FloatGrid>("density");
  const auto color = back.find<openvdb::Vec3SGrid>("Cd");
  const auto source = back.find<openvdb::Vec3IGrid>("source");
  ASSERT_TRUE(id && density && color && source);
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) {
        const openvdb::Coord at(x, y, z);
        ASSERT_EQ(id->tree().getValue(at), test::formula_id(x, y, z));
        ASSERT_EQ(density->tree().getValue(at), test::formula_density(x, y, z));
        ASSERT_EQ(color->tree().getValue(at), openvdb::Vec3s(0.5f, 0.25f * float(x), float(z)));
        ASSERT_EQ(source->tree().getValue(at), openvdb::Vec3i(x, y, z));
      }
  EXPECT_EQ(id->transform(), *voxel_transform(0.25));
  EXPECT_EQ(id->activeVoxelCount(), v.find<openvdb::Int32Grid>("id")->activeVoxelCount());
  EXPECT_EQ(
      loaded_dream3d(file, "FeatureIds").find<openvdb::Int32Grid>("FeatureIds")->tree().getValue({1, 0, 0}),
      6);
  EXPECT_EQ(test::code_of([&] { loaded_dream3d(file, "nothing"); }), "no-such-grid");
  // The same content gives the same bytes.
  EXPECT_EQ(test::content_of(file), test::content_of(dream3d_of(v)));
}

TEST(ExportDream3d, ABlockKeepsItsPlace) {
  Volume v;
  auto moved = openvdb::FloatGrid::create(0);
  moved->setName("density");
  moved->setTransform(voxel_transform(0.25));
  moved->tree().setValue(openvdb::Coord(-3, 7, 100), 5);
  moved->tree().setValue(openvdb::Coord(-1, 9, 101), 6);
  v.grids = {moved};
  const Volume back = loaded_dream3d(dream3d_of(v));
  EXPECT_EQ(back.resolution, Vec3i::Zero());
  const auto density = back.find<openvdb::FloatGrid>("density");
  ASSERT_TRUE(density);
  EXPECT_EQ(density->tree().getValue(openvdb::Coord(-3, 7, 100)), 5);
  EXPECT_EQ(density->tree().getValue(openvdb::Coord(-1, 9, 101)), 6);
}

TEST(ExportDream3d, ContainsItsProvenance) {
  const Volume v = test::formula_volume();
  const VoxelBox box = voxel_box(v);
  const std::string long_text =
      "{\"text\":\"" + std::string(100000, 'x') + "\"}";  // longer than an attribute may be
  const fs::path file = test::temporary_folder() / "a.dream3d";
  write_dream3d(file, {box, {VoxelSource(v, "density", box)}, nullptr, nullptr, nullptr, long_text});
  EXPECT_EQ(read_provenance(file), long_text);
}

TEST(ExportDream3d, SaysWhatItCannotHold) {
  const auto code = [](const Volume& v, std::map<std::string, std::string> parameters = {}) {
    return test::code_of([&] { dream3d_of(v, parameters); });
  };
  EXPECT_EQ(code(Volume()), "no-grids");
  EXPECT_EQ(code(test::formula_volume(), {{"grids", "[nothing]"}}), "no-such-grid");
  EXPECT_EQ(code(test::formula_volume(), {{"regions", "phases"}}), "missing-input");
  for (const char* name : {"Phases", "a/b"}) {
    Volume v = test::formula_volume();
    auto grid = v.find<openvdb::FloatGrid>("density")->deepCopy();
    grid->setName(name);
    v.grids.push_back(grid);
    EXPECT_EQ(code(v), "bad-names") << name;
  }
  const Volume v = test::formula_volume();
  const fs::path folder = test::temporary_folder();
  const test::FullDisk full(2000);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Export", {{"volume", Value::of(v)}}, {{"path", "a.dream3d"}}, folder);
            }),
            "write-failed");
}

// Bytes set to three values each, and shorter files: a result or an error that says what is wrong.
TEST(DamagedDream3d, IsAResultOrAnError) {
  Volume v;
  auto id = openvdb::Int32Grid::create(-1);
  id->setName("id");
  id->setTransform(voxel_transform(0.25));
  for (int i = 0; i < 3; ++i) id->tree().setValue(openvdb::Coord(i, i % 2, 0), i);
  v.grids = {id};
  v.resolution = Vec3i(3, 2, 1);
  const std::string good = test::content_of(dream3d_of(v));
  const fs::path file = test::temporary_folder() / "bad.dream3d";
  Reading reading;
  reading.memory = 100'000'000;
  std::size_t read = 0, refused = 0;
  const auto attempt = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    const std::string code = test::code_of([&] { load_volume::read_dream3d(file, "", {}, reading); });
    ++(code.empty() ? read : refused);
    const std::set<std::string> known = {"",           "unreadable-volume", "not-a-volume", "too-large",
                                         "no-spacing", "bad-values",        "no-such-grid"};
    EXPECT_TRUE(known.count(code)) << code;
    read_provenance(file);
  };
  for (std::size_t at = 0; at < good.size(); at += 1 + at / 100)
    for (const char value : {'\0', '\x7f', '\xff'}) {
      std::string bytes = good;
      bytes[at] = value;
      attempt(bytes);
    }
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 20) attempt(good.substr(0, size));
  EXPECT_GT(read, 200u);
  EXPECT_GT(refused, 200u);
}

// A dataset says that it has 2³⁰ voxels, but the file has none of them.
TEST(DamagedDream3d, LargeSizesNeedNoMemory) {
  std::string bytes = test::content_of(dream3d_of(test::formula_volume()));
  const auto put = [&](const std::string& from, const std::string& to) {
    for (auto at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at + 1))
      bytes.replace(at, to.size(), to);
  };
  const auto number = [](std::uint64_t v) { return std::string(reinterpret_cast<const char*>(&v), 8); };
  put(number(4) + number(5) + number(6), number(1024) + number(1024) + number(1024));
  put(number(6) + number(5) + number(4), number(1024) + number(1024) + number(1024));
  const fs::path file = test::temporary_folder() / "bad.dream3d";
  std::ofstream(file, std::ios::binary) << bytes;
  Reading reading;
  reading.memory = 100'000'000;
  EXPECT_EQ(test::code_of([&] { load_volume::read_dream3d(file, "", {}, reading); }), "too-large");
  reading.memory = std::uint64_t{1} << 40;
  EXPECT_EQ(test::code_of([&] { load_volume::read_dream3d(file, "", {}, reading); }), "unreadable-volume");
}

}  // namespace
}  // namespace terrazzo
