// DICOM series, written by DCMTK itself.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/scan.h"
#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

struct SliceFile {
  double z = 0;
  int first = 0;
  std::string series = "1.2.3";
  double slope = 1, intercept = 0, dx = 0.7, dy = 0.8;
  bool rescaled = true;
  Uint16 bits = 16;
  bool turned = false;  // rows run to the patient's right
};

void write(const fs::path& path, const SliceFile& s) {
  DcmFileFormat file;
  DcmDataset& set = *file.getDataset();
  const auto text = [&](const DcmTagKey& tag, const std::string& v) {
    ASSERT_TRUE(set.putAndInsertString(tag, v.c_str()).good()) << v;
  };
  text(DCM_SOPClassUID, UID_CTImageStorage);
  text(DCM_SOPInstanceUID, "1.2.3.4");
  text(DCM_SeriesInstanceUID, s.series);
  text(DCM_PhotometricInterpretation, "MONOCHROME2");
  set.putAndInsertUint16(DCM_SamplesPerPixel, 1);
  set.putAndInsertUint16(DCM_Rows, 2);
  set.putAndInsertUint16(DCM_Columns, 3);
  set.putAndInsertUint16(DCM_BitsAllocated, 16);
  set.putAndInsertUint16(DCM_BitsStored, s.bits);
  set.putAndInsertUint16(DCM_HighBit, Uint16(s.bits - 1));
  set.putAndInsertUint16(DCM_PixelRepresentation, 1);
  text(DCM_PixelSpacing, fmt::format("{}\\{}", s.dy, s.dx));
  text(DCM_ImagePositionPatient, fmt::format("-10\\-20\\{}", s.z));
  text(DCM_ImageOrientationPatient, s.turned ? "-1\\0\\0\\0\\-1\\0" : "1\\0\\0\\0\\1\\0");
  if (s.rescaled) {
    text(DCM_RescaleSlope, fmt::format("{}", s.slope)),
        text(DCM_RescaleIntercept, fmt::format("{}", s.intercept));
  }
  const int mask = (1 << s.bits) - 1;
  Uint16 values[6];
  for (int i = 0; i < 6; ++i) values[i] = static_cast<Uint16>((s.first + i) & mask);
  set.putAndInsertUint16Array(DCM_PixelData, values, 6);
  ASSERT_TRUE(file.saveFile(path.c_str(), EXS_LittleEndianExplicit).good());
}

float at(const test::NodeRun& run, int x, int y, int z) {
  return run.output<Volume>("volume").find<openvdb::FloatGrid>("density")->tree().getValue(
      openvdb::Coord(x, y, z));
}

TEST(LoadDicom, SlicesAreSortedByPlaceAndRescaled) {
  const auto folder = test::temporary_folder();
  // The file names contradict the positions. The patient's left is −x and back is −y here.
  write(folder / "a.dcm", {.z = 7.5, .first = 300, .slope = 2, .intercept = -1000});
  write(folder / "b.dcm", {.z = 2.5, .first = 100, .slope = 2, .intercept = -1000});
  write(folder / "c.dcm", {.z = 5, .first = 200, .slope = 2, .intercept = -1000});
  const auto run = test::load_volume(folder / "*.dcm");
  const auto g = run.output<Volume>("volume").find<openvdb::FloatGrid>("density");
  EXPECT_EQ(g->evalActiveVoxelBoundingBox().dim(), openvdb::Coord(3, 2, 3));
  EXPECT_TRUE(g->voxelSize().eq(openvdb::Vec3d(0.7, 0.8, 2.5), 1e-6)) << g->voxelSize();
  for (int z = 0; z < 3; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 3; ++x)
        EXPECT_EQ(at(run, 2 - x, 1 - y, z), 2 * (100 * (z + 1) + 3 * y + x) - 1000) << x << y << z;
  EXPECT_TRUE(run.warnings.empty());
}

TEST(LoadDicom, TurnedSlicesComeOutTheSameWayRound) {
  const auto folder = test::temporary_folder();
  for (int k = 0; k < 2; ++k)
    write(folder / ("t" + std::to_string(k) + ".dcm"),
          {.z = 3.0 * k, .first = 10 * k, .slope = 2, .turned = true});
  const auto run = test::load_volume(folder / "t*.dcm");
  EXPECT_EQ(at(run, 0, 0, 0), 0);
  EXPECT_EQ(at(run, 2, 1, 1), 30);
}

TEST(LoadDicom, BadSeries) {
  const auto folder = test::temporary_folder();
  const auto code = [&](const char* glob) {
    return test::code_of([&] { test::load_volume(folder / glob); });
  };
  write(folder / "g1.dcm", {.z = 0}), write(folder / "g2.dcm", {.z = 2}), write(folder / "g3.dcm", {.z = 4}),
      write(folder / "g4.dcm", {.z = 10});
  EXPECT_EQ(code("g*.dcm"), "missing-slices");
  write(folder / "m1.dcm", {.z = 0});
  write(folder / "m2.dcm", {.z = 2, .series = "1.2.4"});
  EXPECT_EQ(code("m*.dcm"), "mixed-series");
  write(folder / "s1.dcm", {.z = 0});
  write(folder / "s2.dcm", {.z = 2, .dx = 0.9});
  EXPECT_EQ(code("s*.dcm"), "mixed-series");
  write(folder / "d1.dcm", {.z = 1});
  write(folder / "d2.dcm", {.z = 1});
  EXPECT_EQ(code("d*.dcm"), "missing-slices");
  std::ifstream in(folder / "g1.dcm", std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  for (const std::size_t size : {std::size_t{140}, whole.size() / 2, whole.size() - 3}) {
    std::ofstream(folder / "cut.dcm", std::ios::binary) << whole.substr(0, size);
    EXPECT_EQ(code("cut.dcm"), "unreadable-volume") << size;
  }
}

TEST(LoadDicom, DamagedFilesNeverCrash) {
  const auto folder = test::temporary_folder();
  write(folder / "good.dcm", {.z = 1, .first = 9});
  std::ifstream in(folder / "good.dcm", std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  for (std::uint64_t k = 0; k < 250; ++k) {
    Random r(4, 4, k);
    std::string bytes = whole;
    for (int flips = 0; flips < 1 + static_cast<int>(k % 4); ++flips)
      bytes[132 + r.below(bytes.size() - 132)] = static_cast<char>(r.below(256));
    if (k % 5 == 0) bytes.resize(132 + r.below(bytes.size() - 132));
    std::ofstream(folder / "bad.dcm", std::ios::binary) << bytes;
    try {
      test::load_volume(folder / "bad.dcm", {{"spacing", "1"}});
    } catch (const Error& e) {
      EXPECT_GT(e.diagnostic().message.size(), 10u);
    }
  }
}

// Each level needs 20 bytes of the file, and more of DCMTK's stack, since DCMTK reads sequences recursively.
TEST(LoadDicom, SequencesWithinSequencesAreBounded) {
  const auto folder = test::temporary_folder();
  write(folder / "good.dcm", {.z = 1});
  const std::string sequence("\x08\x00\x40\x11SQ\0\0\xff\xff\xff\xff", 12),
      item("\xfe\xff\x00\xe0\xff\xff\xff\xff", 8);
  std::string bytes = *read_file(folder / "good.dcm");
  const auto meta_end = bytes.find(std::string("\x08\x00\x16\x00", 4));
  ASSERT_NE(meta_end, std::string::npos);
  std::string nested;
  for (int i = 0; i < 200'000; ++i) nested += sequence + item;
  std::ofstream(folder / "deep.dcm", std::ios::binary) << bytes.substr(0, meta_end) + nested;
  EXPECT_EQ(test::code_of([&] { test::load_volume(folder / "deep.dcm"); }), "unreadable-volume");
}

TEST(LoadDicom, TheBudgetIsKept) {
  const auto folder = test::temporary_folder();
  write(folder / "a.dcm", {.z = 1});
  Reading little;
  little.memory = 1000;
  EXPECT_EQ(test::code_of([&] { load_volume::read_dicom({folder / "a.dcm"}, {}, little); }), "too-large");
  little.memory = 10'000;
  EXPECT_EQ(load_volume::read_dicom({folder / "a.dcm"}, {}, little).values.size(), 6u);
}

TEST(LoadDicom, SaysWhereNothingTellsTheRescale) {
  const auto folder = test::temporary_folder();
  for (const bool rescaled : {false, true}) {
    write(folder / "r1.dcm", {.z = 0, .first = 5, .rescaled = rescaled});
    write(folder / "r2.dcm", {.z = 2, .rescaled = rescaled});
    const auto run = test::load_volume(folder / "r*.dcm");
    EXPECT_EQ(run.warnings.size(), rescaled ? 0u : 1u);
    EXPECT_EQ(at(run, 2, 1, 0), 5);
  }
}

TEST(LoadDicom, NumbersBelowSixteenBitsKeepTheirSign) {
  const auto folder = test::temporary_folder();
  write(folder / "a.dcm", {.z = 0, .first = -7, .bits = 12}),
      write(folder / "b.dcm", {.z = 1, .first = 90, .bits = 12});
  const auto run = test::load_volume(folder / "*.dcm");
  EXPECT_EQ(at(run, 2, 1, 0), -7);
  EXPECT_EQ(at(run, 0, 0, 1), 95);
}

}  // namespace
}  // namespace terrazzo
