// OpenVDB and NIfTI files that are truncated, damaged, or whose headers claim more than they contain.
#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <zlib.h>

#include <cstring>
#include <fstream>

#include "nodes/data/volume.h"
#include "nodes/export/formats/vdb_file.h"
#include "nodes/volumes/load_volume/scan.h"
#include "nodes/volumes/load_volume/vdb.h"
#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/load_volume/nifti_file.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

class DamagedVolume : public ::testing::Test {
 protected:
  DamagedVolume() { initialize_openvdb(); }
  // One grid of every type, with tiles, children, active and inactive values.
  std::string vdb() {
    Volume v;
    v.resolution = Vec3i(16, 16, 16);
    const auto add = [&]<class Grid>(const char* name, typename Grid::ValueType background, auto value) {
      auto g = Grid::create(background);
      g->setName(name);
      g->setTransform(voxel_transform(0.25));
      for (int i = 0; i < 200; ++i)
        g->tree().setValue(openvdb::Coord(i % 7 - 3, i % 11 * 3, i - 40), value(i));
      g->tree().addTile(1, openvdb::Coord(512, 0, 0), value(3), true);
      g->tree().addTile(3, openvdb::Coord(8192, 0, 0), value(4), true);
      v.grids.push_back(g);
    };
    add.template operator()<openvdb::FloatGrid>("density", 1.5f, [](int i) { return 0.1f * float(i); });
    add.template operator()<openvdb::DoubleGrid>("d", 0.0, [](int i) { return 0.1 * i; });
    add.template operator()<openvdb::Vec3SGrid>("Cd", openvdb::Vec3s(0),
                                                [](int i) { return openvdb::Vec3s(float(i)); });
    add.template operator()<openvdb::Int32Grid>("n", 0, [](int i) { return i; });
    add.template operator()<openvdb::BoolGrid>("b", false, [](int i) { return i % 2 == 0; });
    volume = v;
    write_vdb(folder / "good.vdb", v, "{}", exporting::WholeNumbers::Int32);
    return *read_file(folder / "good.vdb");
  }
  struct Outcome {
    std::string code, message;
  };
  Outcome read(const std::string& bytes, std::uint64_t memory = 200'000'000) {
    std::ofstream(folder / "bad.vdb", std::ios::binary) << bytes;
    Reading reading;
    reading.memory = memory;
    try {
      load_volume::read_vdb(folder / "bad.vdb", "", reading);
      return {};
    } catch (const Error& e) {
      return {e.diagnostic().code, e.diagnostic().message};
    }
  }
  static std::vector<char> encoded(const Volume& v) {
    BufferWriter w;
    value_type<Volume>().encode(&v, w);
    return {w.buffer.begin(), w.buffer.end()};
  }
  fs::path folder = test::temporary_folder();
  Volume volume;
};

TEST_F(DamagedVolume, GridsOfEveryTypeComeBackAsTheyWere) {
  vdb();
  EXPECT_EQ(encoded(load_volume::read_vdb(folder / "good.vdb", "")), encoded(volume));
  for (const char* name : {"density", "d", "Cd", "n", "b"})
    EXPECT_EQ(load_volume::read_vdb(folder / "good.vdb", name).grids.at(0)->getName(), name);
}

// Grids that share a tree, half floats, and each compression of OpenVDB's own writer.
TEST_F(DamagedVolume, FilesOfOpenVdbsOwnWriter) {
  vdb();
  for (const bool half : {false, true})
    for (const std::uint32_t compression : {0u, 1u, 2u, 3u, 4u, 6u}) {
      openvdb::GridPtrVec grids;
      for (const auto& g : volume.grids) grids.push_back(g->deepCopyGrid());
      for (auto& g : grids) g->setSaveFloatAsHalf(half);
      auto twin = grids[0]->copyGrid();
      twin->setName("twin");
      grids.push_back(twin);
      openvdb::io::File file((folder / "own.vdb").string());
      file.setCompression(compression);
      file.write(grids);
      file.close();
      const Volume back = load_volume::read_vdb(folder / "own.vdb", "");
      ASSERT_EQ(back.grids.size(), 6u);
      if (half) {
        openvdb::io::File again((folder / "own.vdb").string());
        again.open(false);
        const auto theirs = again.readGrid("density");
        const auto ours = openvdb::gridConstPtrCast<openvdb::FloatGrid>(back.grids[0]);
        for (auto it = openvdb::gridConstPtrCast<openvdb::FloatGrid>(theirs)->cbeginValueAll(); it; ++it)
          EXPECT_EQ(ours->tree().getValue(it.getCoord()), *it);
      } else {
        Volume first;
        first.resolution = volume.resolution;
        first.grids = {back.grids.begin(), back.grids.begin() + 5};
        Volume expected;
        expected.resolution = volume.resolution;
        expected.grids = {grids.begin(), grids.begin() + 5};
        EXPECT_EQ(encoded(first), encoded(expected)) << compression;
      }
      EXPECT_EQ(back.find<openvdb::FloatGrid>("twin")->activeVoxelCount(),
                back.find<openvdb::FloatGrid>("density")->activeVoxelCount());
    }
}

TEST_F(DamagedVolume, ACutVdbIsAnError) {
  const std::string whole = vdb();
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 20)
    EXPECT_EQ(read(whole.substr(0, size)).code, "unreadable-volume") << size;
  EXPECT_EQ(read(whole.substr(0, whole.size() - 1)).code, "unreadable-volume");
}

// Flipped bytes and lengths anywhere: a volume or an error message of at most a few hundred bytes, within the
// memory budget.
TEST_F(DamagedVolume, AMutatedVdbStaysWithinItsBudget) {
  const std::string whole = vdb();
  const std::uint32_t lengths[] = {0xffffffff, 0x7fffffff, 0x40000000, 0, 1, 0x10000};
  for (std::uint64_t k = 0; k < 400; ++k) {
    Random r(6, 6, k);
    std::string bytes = whole;
    const std::size_t at = r.below(k % 2 ? bytes.size() : 2000);
    if (k % 3 == 0)
      bytes[at] = static_cast<char>(r.below(256));
    else if (at + 4 <= bytes.size())
      std::memcpy(&bytes[at], &lengths[r.below(6)], 4);
    EXPECT_LT(read(bytes).message.size(), 600u);
  }
}

TEST_F(DamagedVolume, AVdbThatNeedsMoreThanTheBudgetIsRefused) {
  const std::string whole = vdb();
  EXPECT_EQ(read(whole, whole.size() + 100'000).code, "too-large");
  EXPECT_EQ(read(whole, 100).code, "too-large");
}

TEST_F(DamagedVolume, ANiftiThatNeedsMoreThanTheBudgetIsRefused) {
  test::NiftiFile n = test::NiftiFile::counting();
  n.dim = {3, 200, 100, 50, 1, 1, 1, 1};
  n.data = std::string(2'000'000, '\1');
  n.write(folder / "a.nii");
  Reading little;
  little.memory = 5'000'000;
  EXPECT_EQ(test::code_of([&] { load_volume::read_nifti(folder / "a.nii", {}, little); }), "too-large");
  EXPECT_EQ(load_volume::read_nifti(folder / "a.nii").count(), 1'000'000u);
}

TEST_F(DamagedVolume, ACutOrChangedCompressedNiftiIsAnError) {
  const std::string whole = *read_file(test::NiftiFile::counting().write(folder / "a.nii"));
  const auto write_gz = [&](const fs::path& path) {
    gzFile f = gzopen(path.c_str(), "wb");
    gzwrite(f, whole.data(), static_cast<unsigned>(whole.size()));
    gzclose(f);
    return *read_file(path);
  };
  const std::string packed = write_gz(folder / "a.nii.gz");
  const auto code = [&](const std::string& bytes) {
    std::ofstream(folder / "b.nii.gz", std::ios::binary) << bytes;
    return test::code_of([&] { load_volume::read_nifti(folder / "b.nii.gz"); });
  };
  ASSERT_EQ(code(packed), "");
  for (std::size_t less = 1; less < packed.size(); less += 3)
    EXPECT_EQ(code(packed.substr(0, packed.size() - less)), "unreadable-volume") << less;
  std::string changed = packed;
  changed[packed.size() - 6] ^= 1;  // of the checksum
  EXPECT_EQ(code(changed), "unreadable-volume");
}

TEST_F(DamagedVolume, ANiftiExtensionCannotAskForMoreThanTheFileHolds) {
  test::NiftiFile n = test::NiftiFile::counting();
  n.voxels_at = 2e9f;
  EXPECT_EQ(test::code_of([&] { load_volume::read_nifti(n.write(folder / "a.nii")); }), "unreadable-volume");
}

}  // namespace
}  // namespace terrazzo
