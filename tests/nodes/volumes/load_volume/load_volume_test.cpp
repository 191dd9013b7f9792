#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include "nodes/data/volume.h"
#include "nodes/export/formats/vdb_file.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/nodes/volumes/load_volume/nifti_file.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;
using test::code_of;
using test::run_node;

using Nifti = test::NiftiFile;
Nifti counting() { return Nifti::counting(); }

openvdb::FloatGrid::ConstPtr grid_of(const test::NodeRun& run, const char* name = "density") {
  return run.output<Volume>("volume").find<openvdb::FloatGrid>(name);
}
float at(const openvdb::FloatGrid::ConstPtr& g, int x, int y, int z) {
  return g->tree().getValue(openvdb::Coord(x, y, z));
}

TEST(LoadVolume, NiftiKeepsNumbersAndSpacing) {
  const auto folder = test::temporary_folder();
  const auto run = test::load_volume(counting().write(folder / "a.nii"));
  const auto g = grid_of(run);
  ASSERT_TRUE(g);
  EXPECT_EQ(g->activeVoxelCount(), 12u);
  EXPECT_EQ(g->voxelSize(), openvdb::Vec3d(0.5, 0.5, 4));
  EXPECT_EQ(at(g, 2, 1, 1), 110);
  EXPECT_EQ(at(g, 1, 0, 1), 70);
  EXPECT_TRUE(run.warnings.empty());
  EXPECT_EQ(run.metrics.at("max"), 110);
}

TEST(LoadVolume, NiftiOfTheOtherByteOrderAndOfFloats) {
  const auto folder = test::temporary_folder();
  Nifti n;
  n.swapped = true;
  n.fill<std::int16_t>(12, [](std::size_t i) { return static_cast<std::int16_t>(300 * i - 1000); });
  EXPECT_EQ(at(grid_of(test::load_volume(n.write(folder / "swapped.nii"))), 2, 1, 1), 2300);
  Nifti f;
  f.datatype = 16;
  f.bits = 32;
  f.fill<float>(12, [](std::size_t i) { return 0.25f * float(i); });
  EXPECT_EQ(at(grid_of(test::load_volume(f.write(folder / "float.nii"))), 2, 0, 1), 2);
}

TEST(LoadVolume, RescaleIsTheFilesUnlessWritten) {
  const auto folder = test::temporary_folder();
  Nifti n = counting();
  n.slope = 2;
  n.intercept = -1024;
  const auto path = n.write(folder / "a.nii");
  EXPECT_EQ(at(grid_of(test::load_volume(path)), 1, 0, 0), -1004);
  EXPECT_EQ(at(grid_of(test::load_volume(path, {{"slope", "3"}})), 1, 0, 0), -994);
  EXPECT_EQ(at(grid_of(test::load_volume(path, {{"slope", "3"}, {"intercept", "1"}})), 1, 0, 0), 31);
  n.slope = 0;  // the standard's encoding of "no rescale"
  const auto run = test::load_volume(n.write(folder / "b.nii"));
  EXPECT_EQ(at(grid_of(run), 1, 0, 0), 10);
  EXPECT_EQ(run.warnings.size(), 1u);
}

// x to the right, y to the front, z to the head, for any axes in the file.
TEST(LoadVolume, AxesAreTurnedToThoseOfSpace) {
  const auto folder = test::temporary_folder();
  Nifti n = counting();  // 3 × 2 × 2
  n.sform = 1;
  // First index: down (−z), second: to the left (−x), third: to the front.
  n.srow = {0, -2, 0, 0, 0, 0, 5, 0, -0.5f, 0, 0, 0};
  const auto run = test::load_volume(n.write(folder / "a.nii"));
  const auto g = grid_of(run);
  EXPECT_EQ(g->evalActiveVoxelBoundingBox().dim(), openvdb::Coord(2, 2, 3));
  EXPECT_EQ(g->voxelSize(), openvdb::Vec3d(2, 5, 0.5));
  // Voxel (i, j, k) of the file becomes (1 − j, k, 2 − i).
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) EXPECT_EQ(at(g, 1 - j, k, 2 - i), 10 * (i + 3 * j + 6 * k));
  EXPECT_TRUE(run.warnings.empty());
  n.srow = {1, 0.2f, 0, 0, -0.2f, 1, 0, 0, 0, 0, 1, 0};
  EXPECT_EQ(test::load_volume(n.write(folder / "tilted.nii")).warnings.size(), 1u);
}

TEST(LoadVolume, BadNifti) {
  const auto folder = test::temporary_folder();
  Nifti cut = counting();
  cut.data.resize(15);
  EXPECT_EQ(code_of([&] { test::load_volume(cut.write(folder / "cut.nii")); }), "unreadable-volume");
  std::ofstream(folder / "junk.nii") << "nothing of the kind";
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "junk.nii"); }), "unreadable-volume");
  Nifti series = counting();
  series.dim = {4, 3, 2, 1, 2, 1, 1, 1};
  EXPECT_EQ(code_of([&] { test::load_volume(series.write(folder / "series.nii")); }), "not-a-volume");
  Nifti rgb = counting();
  rgb.datatype = 128;
  rgb.bits = 24;
  rgb.data.resize(36);
  EXPECT_EQ(code_of([&] { test::load_volume(rgb.write(folder / "rgb.nii")); }), "not-a-volume");
  Nifti without = counting();
  without.pixdim = {1, 0, 0, 0, 0, 0, 0, 0};
  const auto path = without.write(folder / "without.nii");
  EXPECT_EQ(code_of([&] { test::load_volume(path); }), "no-spacing");
  EXPECT_EQ(grid_of(test::load_volume(path, {{"spacing", "[1, 2, 3]"}}))->voxelSize(),
            openvdb::Vec3d(1, 2, 3));
  EXPECT_EQ(code_of([&] { test::load_volume(path, {{"spacing", "[1, 2]"}}); }), "bad-spacing");
  Nifti nan;
  nan.datatype = 16;
  nan.bits = 32;
  nan.fill<float>(12, [](std::size_t i) { return i == 7 ? NAN : 1.0f; });
  EXPECT_EQ(code_of([&] { test::load_volume(nan.write(folder / "nan.nii")); }), "bad-values");
  Nifti huge = counting();
  huge.dim = {3, 32767, 32767, 32767, 1, 1, 1, 1};
  EXPECT_EQ(code_of([&] { test::load_volume(huge.write(folder / "huge.nii")); }), "too-large");
  huge.dim = {3, 1024, 1024, 1024, 1, 1, 1, 1};
  EXPECT_EQ(code_of([&] { test::load_volume(huge.write(folder / "huge.nii")); }), "unreadable-volume");
  Nifti one;
  one.dim = {3, 1, 1, 1, 1, 1, 1, 1};
  one.fill<std::int16_t>(1, [](std::size_t) -> std::int16_t { return 5; });
  EXPECT_EQ(grid_of(test::load_volume(one.write(folder / "one.nii")))->activeVoxelCount(), 1u);
}

// Any bytes result in a volume or an error with a message.
TEST(LoadVolume, DamagedNiftiNeverCrashes) {
  const auto folder = test::temporary_folder();
  const auto good = counting().write(folder / "good.nii");
  std::ifstream in(good, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  int loaded = 0;
  for (std::uint64_t k = 0; k < 250; ++k) {
    Random r(3, 3, k);
    std::string bytes = whole;
    for (int flips = 0; flips < 1 + static_cast<int>(k % 4); ++flips)
      bytes[r.below(k % 2 ? 120 : bytes.size())] = static_cast<char>(r.below(256));
    std::ofstream(folder / "bad.nii", std::ios::binary) << bytes;
    try {
      test::load_volume(folder / "bad.nii");
      ++loaded;
    } catch (const Error& e) {
      EXPECT_GT(e.diagnostic().message.size(), 10u);
    }
  }
  EXPECT_GT(loaded, 10);
}

fs::path slice(const fs::path& path, int channels, const std::vector<std::uint16_t>& v, int w, int h) {
  test::write_picture(path, w, h, channels, Sample::UInt16, v);
  return path;
}

TEST(LoadVolume, PicturesAreSlicesFromBelow) {
  const auto folder = test::temporary_folder();
  slice(folder / "s_1.png", 1, {1, 2, 3, 4, 5, 65535}, 3, 2);
  slice(folder / "s_2.png", 1, {11, 12, 13, 14, 15, 16}, 3, 2);
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "s_*.png"); }), "no-spacing");
  const auto run =
      test::load_volume(folder / "s_*.png", {{"spacing", "0.5"}, {"slope", "2"}, {"intercept", "-1"}});
  const auto g = grid_of(run);
  EXPECT_EQ(g->evalActiveVoxelBoundingBox().dim(), openvdb::Coord(3, 2, 2));
  EXPECT_EQ(at(g, 0, 1, 0), 1);  // the first row is the top one
  EXPECT_EQ(at(g, 0, 0, 0), 7);
  EXPECT_EQ(at(g, 2, 0, 0), 131069);
  EXPECT_EQ(at(g, 2, 0, 1), 31);
  EXPECT_EQ(test::load_volume(folder / "s_*.png", {{"spacing", "1"}}).warnings.size(), 1u)
      << "no rescale in the file";
  slice(folder / "s_3.png", 1, {1, 2}, 1, 2);
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "s_*.png", {{"spacing", "1"}}); }), "size-mismatch");
  slice(folder / "c.png", 3, {1, 2, 3}, 1, 1);
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "c.png", {{"spacing", "1"}}); }), "not-a-volume");
  std::ofstream(folder / "text.dat") << "no picture";
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "text.dat", {{"spacing", "1"}}); }), "unreadable-image");
}

TEST(LoadVolume, OpenVdbComesBackAsItWasWritten) {
  initialize_openvdb();
  const auto folder = test::temporary_folder();
  Volume v;
  v.resolution = Vec3i(4, 4, 4);
  auto a = openvdb::FloatGrid::create(-3);
  a->setName("a");
  a->setTransform(voxel_transform(0.25));
  a->tree().setValue(openvdb::Coord(1, 2, 3), 7);
  auto b = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  b->setName("Cd");
  b->setTransform(voxel_transform(0.25));
  b->tree().setValue(openvdb::Coord(0), openvdb::Vec3s(1, 2, 3));
  v.grids = {a, b};
  write_vdb(folder / "v.vdb", v, "");
  const auto run = test::load_volume(folder / "v.vdb");
  const auto& back = run.output<Volume>("volume");
  EXPECT_EQ(back.resolution, v.resolution);
  ASSERT_EQ(back.grids.size(), 2u);
  EXPECT_EQ(at(grid_of(run, "a"), 1, 2, 3), 7);
  EXPECT_EQ(grid_of(run, "a")->voxelSize()[0], 0.25);
  EXPECT_EQ(test::load_volume(folder / "v.vdb", {{"grid", "Cd"}}).output<Volume>("volume").grids.size(), 1u);
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "v.vdb", {{"grid", "x"}}); }), "no-such-grid");
  a->tree().setValue(openvdb::Coord(1), NAN);
  write_vdb(folder / "nan.vdb", v, "");
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "nan.vdb"); }), "bad-values");
  std::ofstream(folder / "bad.vdb") << " BDV and then nothing";
  EXPECT_EQ(code_of([&] { test::load_volume(folder / "bad.vdb"); }), "unreadable-volume");
}

TEST(LoadVolume, TheSharedScan) {
  const fs::path path = test::shared_data() / "volumes/abdomen_ct.nii.gz";
  if (!fs::exists(path)) GTEST_SKIP() << "no shared data";
  const auto run = test::load_volume(path);
  const auto g = grid_of(run);
  EXPECT_EQ(g->evalActiveVoxelBoundingBox().dim(), openvdb::Coord(122, 101, 30));
  EXPECT_EQ(g->voxelSize(), openvdb::Vec3d(3, 3, 3));
  EXPECT_LT(run.metrics.at("min"), -900);
  EXPECT_GT(run.metrics.at("max"), 400);
}

}  // namespace
}  // namespace terrazzo
