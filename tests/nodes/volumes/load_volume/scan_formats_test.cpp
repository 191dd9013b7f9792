// NumPy arrays, NRRD, MetaImage and MRC: one number per voxel in files of several types and encodings.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cstring>
#include <fstream>

#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/scan.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

const Vec3i kArraySize(4, 3, 2);

// 24 numbers of type T, x + 10 y + 100 z, x fastest.
template <class T>
std::string counting(bool big_endian = false, double offset = 0) {
  std::string out;
  for (int i = 0; i < kArraySize.prod(); ++i) {
    const T v = static_cast<T>(i % 4 + 10 * (i / 4 % 3) + 100 * (i / 12) + offset);
    std::string bytes(sizeof v, '\0');
    std::memcpy(bytes.data(), &v, sizeof v);
    if (big_endian) std::reverse(bytes.begin(), bytes.end());
    out += bytes;
  }
  return out;
}

fs::path file_of(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

std::string compressed(const std::string& plain, bool gzip) {
  std::string out(plain.size() + 1000, '\0');
  z_stream s{};
  deflateInit2(&s, 6, Z_DEFLATED, gzip ? 31 : 15, 8, Z_DEFAULT_STRATEGY);
  s.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
  s.avail_in = static_cast<uInt>(plain.size());
  s.next_out = reinterpret_cast<Bytef*>(out.data());
  s.avail_out = static_cast<uInt>(out.size());
  deflate(&s, Z_FINISH);
  out.resize(s.total_out);
  deflateEnd(&s);
  return out;
}

openvdb::FloatGrid::ConstPtr scan_grid(const test::NodeRun& run) {
  return run.output<Volume>("volume").find<openvdb::FloatGrid>("density");
}

void expect_counting(const test::NodeRun& run, const char* what, double offset = 0) {
  EXPECT_EQ(run.output<Volume>("volume").extent, kArraySize) << what;
  for (int i = 0; i < kArraySize.prod(); ++i) {
    const openvdb::Coord at(i % 4, i / 4 % 3, i / 12);
    ASSERT_EQ(scan_grid(run)->tree().getValue(at), at.x() + 10 * at.y() + 100 * at.z() + offset)
        << what << at;
  }
}

// Also with a spacing of 0.5 × 0.5 × 2.
void expect_spaced_counting(const fs::path& file, const char* what) {
  const auto run = test::load_volume(file);
  expect_counting(run, what);
  EXPECT_TRUE(scan_grid(run)->voxelSize().eq(openvdb::Vec3d(0.5, 0.5, 2), 1e-12)) << what;
}

test::NodeRun loaded(const fs::path& path) { return test::load_volume(path, {{"spacing", "1"}}); }
std::string code(const fs::path& path, std::map<std::string, std::string> more = {{"spacing", "1"}}) {
  return test::code_of([&] { test::load_volume(path, more); });
}

std::string npy(const std::string& type, const std::string& shape, const std::string& data,
                bool fortran = true, char version = 1) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}", type,
                                   fortran ? "True" : "False", shape);
  const std::size_t room = version == 1 ? 2 : 4;
  header.resize(128 - 8 - room, ' ');
  std::string out = std::string("\x93NUMPY") + version + '\0';
  for (std::size_t k = 0; k < room; ++k) out += static_cast<char>(header.size() >> (8 * k));
  return out + header + data;
}

TEST(LoadNumpy, ReadsEveryTypeOrderAndVersion) {
  const auto folder = test::temporary_folder();
  const auto read = [&](const std::string& content, const char* what, double offset = 0) {
    expect_counting(loaded(file_of(folder / "a.npy", content)), what, offset);
  };
  read(npy("<i2", "(4, 3, 2)", counting<std::int16_t>(false, -50)), "int16", -50);
  read(npy(">u2", "(4, 3, 2)", counting<std::uint16_t>(true)), "big-endian");
  read(npy(">f8", "(4, 3, 2)", counting<double>(true, 0.5)), "big-endian double", 0.5);
  read(npy("<u8", "(4L, 3L, 2L)", counting<std::uint64_t>(), true, 2), "version 2");
  read(npy("|u1", "(4,3,2,)", counting<std::uint8_t>(), true, 3), "version 3");
  // C order: the last index is the fastest.
  std::string turned;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 2; ++z) turned += static_cast<char>(x + 10 * y + 100 * z);
  read(npy("|u1", "(4, 3, 2)", turned, false), "C order");
}

TEST(LoadNumpy, ReadsHalfFloats) {
  const auto folder = test::temporary_folder();
  std::string data;
  for (const int bits : {0x3c00, 0xc000, 0x0001, 0x7bff, 0x0000, 0x3555})
    data += {static_cast<char>(bits), static_cast<char>(bits >> 8)};
  const auto g = scan_grid(loaded(file_of(folder / "a.npy", npy("<f2", "(6, 1, 1)", data))));
  const double expected[] = {1, -2, 5.9604644775390625e-8, 65504, 0, 0.333251953125};
  for (int x = 0; x < 6; ++x) EXPECT_EQ(g->tree().getValue(openvdb::Coord(x, 0, 0)), float(expected[x]));
}

TEST(LoadNumpy, RefusesShapesThatAreNone) {
  const auto folder = test::temporary_folder();
  for (const char* shape : {"(-2, 2.5, 2)", "(2, 2, -2)", "(2, 2, 2.0)", "(2, , 2, 2)", "(a, 2, 2)",
                            "(2, 2, 2e0)", "2, 2, 2", "[2, 2, 2]", "(99999999999999999999, 1, 1)"})
    EXPECT_EQ(code(file_of(folder / "a.npy", npy("|u1", shape, std::string(8, 'a')))), "unreadable-volume")
        << shape;
  EXPECT_EQ(code(file_of(folder / "a.npy", npy("|u1", "(2, 2)", std::string(4, 'a')))), "not-a-volume");
  EXPECT_EQ(code(file_of(folder / "a.npy", npy("<c8", "(1, 1, 1)", std::string(8, 'a')))),
            "unreadable-volume");
}

std::string eight_bytes(std::int64_t v) {
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &v, 8);
  return bytes;
}

// Numbers keep all their digits, or the message has the one that cannot be kept.
TEST(LoadVolume, LabelsKeepTheirDigits) {
  const auto folder = test::temporary_folder();
  const auto ids = [&](const char* type, const std::string& data) {
    const auto path = file_of(folder / "ids.npy", npy(type, "(2, 1, 1)", data));
    return test::load_volume(path, {{"spacing", "1"}, {"grid", "id"}});
  };
  const auto second = [](const test::NodeRun& run) {
    return run.output<Volume>("volume").find<openvdb::Int32Grid>("id")->tree().getValue(
        openvdb::Coord(1, 0, 0));
  };
  EXPECT_EQ(second(ids("<i8", eight_bytes(-1) + eight_bytes(2147483647))), 2147483647);
  EXPECT_EQ(second(ids("<u8", eight_bytes(0) + eight_bytes(16777217))), 16777217);
  EXPECT_EQ(second(ids("<f8", eight_bytes(0) + eight_bytes(std::bit_cast<std::int64_t>(2147483645.0)))),
            2147483645);
  for (const char* type : {"<i8", "<u8"}) try {
      ids(type, eight_bytes(7) + eight_bytes((std::int64_t{1} << 53) + 1));
      ADD_FAILURE() << type;
    } catch (const Error& e) {
      EXPECT_NE(e.diagnostic().message.find("9007199254740993"), std::string::npos) << e.diagnostic().message;
    }
  const auto path =
      file_of(folder / "a.npy", npy("<i4", "(2, 1, 1)", eight_bytes((std::int64_t{16777217} << 32) + 5)));
  try {
    loaded(path);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "bad-values");
    EXPECT_NE(e.diagnostic().message.find("16777217"), std::string::npos) << e.diagnostic().message;
  }
  EXPECT_EQ(code(path, {{"spacing", "1"}, {"slope", "0.5"}}), "") << "scaled numbers are rounded";
}

std::string nrrd(const std::string& fields, const std::string& data = "", const char* dimension = "3") {
  return fmt::format("NRRD0004\n# a comment\ndimension: {}\n{}\n{}", dimension, fields, data);
}

TEST(LoadNrrd, ReadsEncodingsAndByteOrders) {
  const auto folder = test::temporary_folder();
  const auto read = [&](const std::string& content, const char* what) {
    expect_spaced_counting(file_of(folder / "a.nrrd", content), what);
  };
  const std::string common = "sizes: 4 3 2\nspacings: 0.5 0.5 2\nkey:=value\n";
  read(nrrd(common + "type: short\nencoding: raw\nendian: little\n", counting<std::int16_t>()), "raw");
  read(nrrd(common + "type: float\nencoding: raw\nendian: big\n", counting<float>(true)), "big-endian");
  read(nrrd(common + "type: uint16\nendian: little\nencoding: gzip\n",
            compressed(counting<std::uint16_t>(), true)),
       "gzip");
  std::string text;
  for (int i = 0; i < 24; ++i)
    text += fmt::format("{}{}", i % 4 + 10 * (i / 4 % 3) + 100 * (i / 12), i % 5 ? " " : "\n");
  read(nrrd(common + "type: int\nencoding: ascii\n", text), "ascii");
  read(nrrd(common + "type: uchar\nencoding: raw\nbyte skip: -1\n", "skip this" + counting<std::uint8_t>()),
       "at the end");
  read(nrrd(common + "type: uchar\nencoding: raw\nline skip: 1\nbyte skip: 2\n",
            "line\nxx" + counting<std::uint8_t>()),
       "skips");
  file_of(folder / "b.raw", counting<std::int16_t>());
  const auto run = test::load_volume(file_of(
      folder / "b.nhdr", nrrd(common + "type: short\nencoding: raw\nendian: little\ndata file: b.raw\n")));
  expect_counting(run, "detached");
  EXPECT_EQ(load_volume::nrrd_companions(folder / "b.nhdr"), std::vector{folder / "b.raw"});
}

TEST(LoadNrrd, AxesAndUnitsAreThoseOfTheFile) {
  const auto folder = test::temporary_folder();
  const auto run = test::load_volume(
      file_of(folder / "a.nrrd",
              nrrd("sizes: 4 3 2\ntype: uchar\nencoding: raw\nspace: left-posterior-superior\n"
                   "space directions: (100,0,0) (0,0,-200) (0,50,0)\nspace units: \"um\" \"um\" \"um\"\n",
                   counting<std::uint8_t>())));
  const auto g = scan_grid(run);
  EXPECT_EQ(run.output<Volume>("volume").extent, Vec3i(4, 2, 3));
  EXPECT_TRUE(g->voxelSize().eq(openvdb::Vec3d(0.1, 0.05, 0.2), 1e-12)) << g->voxelSize();
  // Voxel (i, j, k) of the file becomes (3 − i, 1 − k, 2 − j).
  EXPECT_EQ(g->tree().getValue(openvdb::Coord(3, 1, 2)), 0);
  EXPECT_EQ(g->tree().getValue(openvdb::Coord(2, 1, 2)), 1);
  EXPECT_EQ(g->tree().getValue(openvdb::Coord(3, 1, 1)), 10);
  EXPECT_EQ(g->tree().getValue(openvdb::Coord(3, 0, 2)), 100);
}

TEST(LoadNrrd, SaysWhatCannotBeRead) {
  const auto folder = test::temporary_folder();
  const std::string common = "sizes: 4 3 2\nspacings: 1 1 1\ntype: uchar\n";
  const auto bad = [&](const std::string& content) { return code(file_of(folder / "a.nrrd", content)); };
  EXPECT_EQ(bad(nrrd(common + "encoding: raw\n", "too short")), "unreadable-volume");
  EXPECT_EQ(bad(nrrd(common + "encoding: bzip2\n", counting<std::uint8_t>())), "unreadable-volume");
  EXPECT_EQ(bad(nrrd(common + "encoding: gzip\n", "no gzip")), "unreadable-volume");
  EXPECT_EQ(bad(nrrd("sizes: 4 3 2\ntype: short\nencoding: raw\n", counting<short>())), "unreadable-volume")
      << "endian";
  EXPECT_EQ(bad(nrrd("sizes: 4 -3 2\ntype: uchar\nencoding: raw\n", counting<char>())), "unreadable-volume");
  EXPECT_EQ(bad(nrrd(common + "encoding: raw\ndata file: ../../etc/passwd\n")), "unreadable-volume");
  EXPECT_EQ(bad(nrrd(common + "encoding: raw\ndata file: LIST\na\nb\n")), "unreadable-volume");
  EXPECT_EQ(bad(nrrd("sizes: 3 4 2 1\ntype: uchar\nencoding: raw\n", counting<char>(), "4")), "")
      << "one entry";
  EXPECT_EQ(bad(nrrd("sizes: 3 4 1 2\ntype: uchar\nencoding: raw\n", counting<char>(), "4")), "");
  EXPECT_EQ(bad(nrrd("sizes: 3 2 2 2\ntype: uchar\nencoding: raw\n", counting<char>(), "4")), "not-a-volume");
  EXPECT_EQ(bad(nrrd("sizes: 4096 4096 4096\ntype: uchar\nencoding: gzip\n", "x")), "too-large");
  EXPECT_EQ(
      code(file_of(folder / "a.nrrd", nrrd("sizes: 4 3 2\ntype: uchar\nencoding: raw\n", counting<char>())),
           {}),
      "no-spacing");
}

std::string meta(const std::string& fields, const std::string& data_file, const std::string& data = "") {
  return "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\n" + fields + "ElementDataFile = " + data_file +
         "\n" + data;
}

TEST(LoadMetaImage, ReadsEncodingsAndByteOrders) {
  const auto folder = test::temporary_folder();
  const auto read = [&](const std::string& content, const char* what) {
    expect_spaced_counting(file_of(folder / "a.mha", content), what);
  };
  const std::string common = "ElementSpacing = 0.5 0.5 2\n";
  read(meta(common + "ElementType = MET_USHORT\n", "LOCAL", counting<std::uint16_t>()), "local");
  read(meta(common + "ElementType = MET_FLOAT\nBinaryDataByteOrderMSB = True\n", "LOCAL",
            counting<float>(true)),
       "big");
  read(meta(common + "ElementType = MET_SHORT\nElementByteOrderMSB = True\n", "LOCAL",
            counting<std::int16_t>(true)),
       "big, by its other name");
  const std::string packed = compressed(counting<std::int32_t>(), false);
  read(meta(common + "ElementType = MET_INT\nCompressedData = True\nCompressedDataSize = " +
                std::to_string(packed.size()) + "\n",
            "LOCAL", packed),
       "zlib");
  file_of(folder / "b.raw", "header" + counting<std::uint8_t>());
  expect_counting(
      test::load_volume(
          file_of(folder / "b.mhd", meta(common + "ElementType = MET_UCHAR\nHeaderSize = -1\n", "b.raw"))),
      "detached");
  EXPECT_EQ(load_volume::metaimage_companions(folder / "b.mhd"), std::vector{folder / "b.raw"});
}

TEST(LoadMetaImage, AxesAreThoseOfTheFile) {
  const auto folder = test::temporary_folder();
  const auto first = [&](const std::string& fields) {
    const auto run = test::load_volume(
        file_of(folder / "a.mha", meta("ElementSpacing = 1 1 1\nElementType = MET_UCHAR\n" + fields, "LOCAL",
                                       counting<std::uint8_t>())));
    return scan_grid(run)->tree().getValue(openvdb::Coord(0, 0, 0));
  };
  EXPECT_EQ(first("TransformMatrix = 1 0 0 0 1 0 0 0 1\n"), 0);
  EXPECT_EQ(first("TransformMatrix = -1 0 0 0 1 0 0 0 1\n"), 3);
  EXPECT_EQ(first("TransformMatrix = 1 0 0 0 1 0 0 0 1\nAnatomicalOrientation = RAI\n"), 23);
  EXPECT_EQ(code(file_of(folder / "u.mha",
                         meta("ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nDistanceUnits = mile\n",
                              "LOCAL", counting<std::uint8_t>())),
                 {}),
            "unreadable-volume");
}

TEST(LoadMetaImage, SaysWhatCannotBeRead) {
  const auto folder = test::temporary_folder();
  const auto bad = [&](const std::string& content) { return code(file_of(folder / "a.mhd", content)); };
  EXPECT_EQ(bad(meta("ElementType = MET_UCHAR\n", "LOCAL", "short")), "unreadable-volume");
  EXPECT_EQ(bad(meta("ElementType = MET_UCHAR\n", "slice%03d.raw 1 2 1")), "unreadable-volume");
  EXPECT_EQ(bad(meta("ElementType = MET_UCHAR\n", "/etc/passwd")), "unreadable-volume");
  EXPECT_EQ(bad(meta("ElementType = MET_UCHAR\n", "missing.raw")), "unreadable-file");
  EXPECT_EQ(bad(meta("ElementType = MET_UCHAR_ARRAY\n", "LOCAL", counting<char>())), "unreadable-volume");
  EXPECT_EQ(bad(meta("ElementType = MET_UCHAR\nElementNumberOfChannels = 3\n", "LOCAL", counting<char>())),
            "not-a-volume");
}

struct MrcFile {
  int mode = 2, group = 1, depth = 2;
  float edge = 1000;
  bool big_endian = false;
  std::array<int, 3> axes = {1, 2, 3};
  std::string extended;
  std::string bytes(const std::string& data) const {
    std::string head(1024, '\0');
    const auto put = [&](std::size_t word, auto v) {
      std::string b(4, '\0');
      std::memcpy(b.data(), &v, 4);
      if (big_endian) std::reverse(b.begin(), b.end());
      head.replace(4 * (word - 1), 4, b);
    };
    const int numbers[] = {4, 3, 2, mode, 0, 0, 0, 4, 3, depth};
    for (std::size_t k = 0; k < 10; ++k) put(k + 1, numbers[k]);
    const float cell[] = {40 * edge, 30 * edge, 40 * edge, 90, 90, 90};  // Å
    for (std::size_t k = 0; k < 6; ++k) put(k + 11, cell[k]);
    for (std::size_t k = 0; k < 3; ++k) put(k + 17, axes[k]);
    put(23, group);
    put(24, static_cast<int>(extended.size()));
    head.replace(208, 4, "MAP ");
    head[212] = head[213] = big_endian ? 0x11 : 0x44;
    return head + extended + data;
  }
};

TEST(LoadMrc, ReadsModesAndByteOrders) {
  const auto folder = test::temporary_folder();
  const auto read = [&](const MrcFile& f, const std::string& data, const char* what, double offset = 0) {
    const auto run = test::load_volume(file_of(folder / "a.map", f.bytes(data)));
    expect_counting(run, what, offset);
    EXPECT_TRUE(scan_grid(run)->voxelSize().eq(openvdb::Vec3d(1e-3, 1e-3, 2e-3), 1e-9))
        << scan_grid(run)->voxelSize();
  };
  read({.mode = 0}, counting<std::int8_t>(false, -60), "signed bytes", -60);
  read({.mode = 1, .big_endian = true}, counting<std::int16_t>(true, -5), "big-endian", -5);
  read({.mode = 2, .extended = std::string(80, 'e')}, counting<float>(), "floats after an extended header");
  read({.mode = 6}, counting<std::uint16_t>(false, 60000), "unsigned", 60000);
  std::string halves;
  for (int i = 0; i < 24; ++i) {  // whole numbers up to 2048 are exact
    const double v = i % 4 + 10 * (i / 4 % 3) + 100 * (i / 12);
    const int e = v == 0 ? 0 : static_cast<int>(std::floor(std::log2(v)));
    const int bits = v == 0 ? 0 : (e + 15) << 10 | static_cast<int>(std::ldexp(v, 10 - e) - 1024);
    halves += {static_cast<char>(bits), static_cast<char>(bits >> 8)};
  }
  read({.mode = 12}, halves, "half floats");
  const auto small =
      file_of(folder / "small.mrc", MrcFile{.mode = 0, .edge = 1}.bytes(counting<std::int8_t>()));
  EXPECT_EQ(code(small, {}), "bad-spacing") << "1 nm";
  EXPECT_EQ(code(small, {{"spacing", "[1, 1, 2]"}}), "") << "in nm";
}

TEST(LoadMrc, AxesAndStacks) {
  const auto folder = test::temporary_folder();
  const auto run = test::load_volume(
      file_of(folder / "a.mrc", MrcFile{.mode = 0, .axes = {3, 2, 1}}.bytes(counting<std::int8_t>())),
      {{"spacing", "1"}});
  EXPECT_EQ(run.output<Volume>("volume").extent, Vec3i(2, 3, 4));
  EXPECT_EQ(scan_grid(run)->tree().getValue(openvdb::Coord(1, 2, 3)), 123);
  const auto bad = [&](const MrcFile& f, const std::string& data) {
    return code(file_of(folder / "a.mrc", f.bytes(data)));
  };
  EXPECT_EQ(bad({.mode = 4}, std::string(192, 'a')), "not-a-volume");
  EXPECT_EQ(bad({.mode = 0, .group = 401, .depth = 1}, counting<char>()), "not-a-volume");
  EXPECT_EQ(bad({.mode = 0, .group = 0, .depth = 1}, counting<char>()), "not-a-volume");
  EXPECT_EQ(bad({.mode = 2}, "short"), "unreadable-volume");
  EXPECT_EQ(bad({.mode = 0, .axes = {1, 1, 3}}, counting<char>()), "unreadable-volume");
}

TEST(LoadVolume, NamesFormatsThatItDoesNotRead) {
  const auto folder = test::temporary_folder();
  const auto message = [&](const char* name, const std::string& content) {
    try {
      test::load_volume(file_of(folder / name, content), {{"spacing", "1"}});
    } catch (const Error& e) {
      return e.diagnostic().message + " " + e.diagnostic().hint;
    }
    return std::string();
  };
  EXPECT_NE(message("a.npz", "PK\3\4 an archive").find("zip"), std::string::npos);
  EXPECT_NE(message("a.vtk", "# vtk DataFile Version 3.0\n").find(".vti"), std::string::npos);
  EXPECT_NE(message("a.nc", "CDF\1 netCDF").find("netCDF"), std::string::npos);
  EXPECT_NE(message("a.mat", "MATLAB 5.0 MAT-file").find("MATLAB"), std::string::npos);
  EXPECT_NE(message("a.raw", std::string(64, '\5')).find(".mhd"), std::string::npos);
  EXPECT_NE(message("a.npy.gz", "\x1f\x8b packed").find("gzip"), std::string::npos);
}

TEST(LoadVolume, TheSharedArrays) {
  const fs::path folder = test::shared_data() / "reports";
  if (!fs::exists(folder / "a.nrrd")) GTEST_SKIP() << "no shared data";
  EXPECT_EQ(test::load_volume(folder / "a.nrrd").output<Volume>("volume").extent, Vec3i(20, 16, 10));
  EXPECT_EQ(loaded(folder / "f16.npy").output<Volume>("volume").extent, Vec3i(10, 16, 20));
  const auto slices = loaded(folder / "unpadded_slices" / "*.png");
  const Vec3i extent = slices.output<Volume>("volume").extent;
  EXPECT_EQ(extent.z(), 12);
  for (int z = 0; z < extent.z(); ++z)
    EXPECT_EQ(scan_grid(slices)->tree().getValue(openvdb::Coord(0, 0, z)), z + 1) << "slice_" << z + 1;
}

}  // namespace
}  // namespace terrazzo
