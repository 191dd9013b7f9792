// Stacks of images as volumes: the stored numbers, and which pages of a file are the slices.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/data/volume.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/tiff_file.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::code_of;
using test::number_bytes;
using test::tiff_file;
using test::TiffPage;

class Slices : public ::testing::Test {
 protected:
  fs::path write(const std::string& bytes, const std::string& name = "a.tif") {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  test::NodeRun load(const fs::path& path, std::map<std::string, std::string> more = {}) {
    more.emplace("spacing", "1");
    return test::load_volume(path, more);
  }
  // The numbers of the voxels, from the top row down as in the file, slice by slice.
  template <class Grid>
  static std::vector<double> numbers_of(const Grid& grid) {
    std::vector<double> out;
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    for (int z = box.min().z(); z <= box.max().z(); ++z)
      for (int y = box.max().y(); y >= box.min().y(); --y)
        for (int x = box.min().x(); x <= box.max().x(); ++x)
          out.push_back(static_cast<double>(grid.tree().getValue(openvdb::Coord(x, y, z))));
    return out;
  }
  std::vector<double> numbers(const test::NodeRun& run, const std::string& name = "density") {
    const auto& volume = run.output<Volume>("volume");
    const auto whole = volume.find<openvdb::Int32Grid>(name);
    return whole ? numbers_of(*whole) : numbers_of(*volume.find<openvdb::FloatGrid>(name));
  }
  std::vector<double> numbers(const TiffPage& page, const test::TiffKind& kind = {}) {
    return numbers(load(write(tiff_file({page}, kind))));
  }
  // A page of one row with two pixels.
  static TiffPage pair(int first, int second, const std::string& description = "") {
    TiffPage page{2, 1};
    page.pixels = {static_cast<char>(first), static_cast<char>(second)};
    page.description = description;
    return page;
  }
  static std::vector<TiffPage> pages(int count, const std::string& description) {
    std::vector<TiffPage> out;
    for (int i = 0; i < count; ++i) out.push_back(pair(i, 100 + i, i == 0 ? description : ""));
    return out;
  }
  fs::path folder = test::temporary_folder();
};

using Numbers = std::vector<double>;

TEST_F(Slices, NumbersAreThoseThatAreStored) {
  const auto page = [](int width, int height, int bits, int format, int photometric,
                       const std::string& pixels) {
    TiffPage p{width, height};
    p.bits = bits;
    p.format = format;
    p.photometric = photometric;
    p.pixels = pixels;
    return p;
  };
  EXPECT_EQ(numbers(page(3, 1, 8, 1, 0, {0, 90, '\xff'})), (Numbers{0, 90, 255})) << "WhiteIsZero";
  EXPECT_EQ(numbers(page(10, 1, 1, 1, 1, {'\xa0', '\x40'})), (Numbers{1, 0, 1, 0, 0, 0, 0, 0, 0, 1}));
  EXPECT_EQ(numbers(page(4, 1, 1, 1, 0, {'\xa0'})), (Numbers{1, 0, 1, 0}));
  EXPECT_EQ(numbers(page(4, 1, 2, 1, 1, {'\x1b'})), (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(numbers(page(3, 2, 4, 1, 1, {'\x0f', '\x30', '\x71', '\x20'})), (Numbers{0, 15, 3, 7, 1, 2}));
  EXPECT_EQ(numbers(page(2, 1, 12, 1, 1, {'\xff', '\xf0', '\x01'})), (Numbers{4095, 1}));
  EXPECT_EQ(numbers(page(3, 1, 8, 2, 1, {'\x80', '\xff', 5})), (Numbers{-128, -1, 5}));
  EXPECT_EQ(numbers(page(3, 1, 16, 1, 1, number_bytes<std::uint16_t>({1, 300, 65535}))),
            (Numbers{1, 300, 65535}));
  EXPECT_EQ(numbers(page(2, 1, 16, 2, 1, number_bytes<std::int16_t>({-32768, 7}))), (Numbers{-32768, 7}));
  EXPECT_EQ(numbers(page(2, 1, 32, 1, 1, number_bytes<std::uint32_t>({3, 1 << 24}))), (Numbers{3, 1 << 24}));
  EXPECT_EQ(numbers(page(2, 1, 32, 2, 1, number_bytes<std::int32_t>({-70000, 12}))), (Numbers{-70000, 12}));
  EXPECT_EQ(numbers(page(2, 1, 64, 2, 1, number_bytes<std::int64_t>({-5, 1 << 20}))), (Numbers{-5, 1 << 20}));
  EXPECT_EQ(numbers(page(2, 1, 64, 1, 1, number_bytes<std::uint64_t>({0, 99}))), (Numbers{0, 99}));
  EXPECT_EQ(numbers(page(3, 1, 16, 3, 1, number_bytes<std::uint16_t>({0x3c00, 0xc000, 0x0001}))),
            (Numbers{1, -2, std::ldexp(1, -24)}))
      << "half";
  EXPECT_EQ(numbers(page(2, 1, 32, 3, 1, number_bytes<float>({0.25f, -1e6f}))), (Numbers{0.25, -1e6}));
  EXPECT_EQ(numbers(page(2, 1, 64, 3, 1, number_bytes<double>({0.5, 1e10}))), (Numbers{0.5, 1e10}));
}

TEST_F(Slices, OtherByteOrdersAndPlanes) {
  for (const bool big_endian : {false, true})
    for (const bool wide : {false, true}) {
      TiffPage p{2, 1};
      p.bits = 16;
      p.pixels = number_bytes<std::uint16_t>({258, 3}, big_endian);
      EXPECT_EQ(numbers(p, {big_endian, wide}), (Numbers{258, 3})) << big_endian << wide;
    }
  TiffPage planes{2, 1};
  planes.samples = 2;
  planes.pixels = {1, 2, 3, 4};
  // Two strips, one for each plane, which lie after the header of 8 bytes.
  planes.tags = {{284, {2}}, {338, {0}}, {273, {8, 10}}, {279, {2, 2}}};
  const fs::path path = write(tiff_file({planes}));
  EXPECT_EQ(code_of([&] { load(path); }), "several-channels");
  EXPECT_EQ(numbers(load(path, {{"channel", "1"}})), (Numbers{1, 2}));
  EXPECT_EQ(numbers(load(path, {{"channel", "2"}})), (Numbers{3, 4}));
  EXPECT_EQ(code_of([&] { load(path, {{"channel", "3"}}); }), "bad-value");
}

TEST_F(Slices, PalettesAreIndices) {
  TiffPage p{3, 1};
  p.bits = 4;
  p.photometric = 3;
  p.pixels = {'\x01', '\xf0'};
  p.tags = {{320, std::vector<std::uint32_t>(48, 40000)}};
  const auto run = load(write(tiff_file({p})));
  EXPECT_EQ(numbers(run), (Numbers{0, 1, 15}));
  const auto tells = [](const std::string& w) { return w.find("palette") != std::string::npos; };
  EXPECT_EQ(std::count_if(run.warnings.begin(), run.warnings.end(), tells), 1);
}

TEST_F(Slices, PhasesAreNumberedFrom0) {
  TiffPage p{3, 1};
  p.pixels = number_bytes<std::uint8_t>({2, 0, 1});
  const auto run = load(write(tiff_file({p})), {{"grid", "phase"}});
  EXPECT_EQ(numbers(run, "phase"), (Numbers{2, 0, 1}));
  EXPECT_TRUE(run.warnings.empty());
  const auto phase = run.output<Volume>("volume").find<openvdb::Int32Grid>("phase");
  EXPECT_EQ(phase->background(), 0);
  EXPECT_EQ(phase->activeVoxelCount(), 3u);
  p.pixels = number_bytes<std::uint8_t>({255, 0, 127});
  const auto mask = load(write(tiff_file({p})), {{"grid", "phase"}});
  EXPECT_EQ(numbers(mask, "phase"), (Numbers{2, 0, 1}));
  ASSERT_EQ(mask.warnings.size(), 1u);
  EXPECT_NE(mask.warnings[0].find("0, 127, 255 become phases 0 to 2"), std::string::npos);
  TiffPage many{256, 1};
  std::vector<std::uint8_t> all(256);
  std::iota(all.begin(), all.end(), std::uint8_t{0});
  many.pixels = number_bytes<std::uint8_t>(all);
  EXPECT_EQ(code_of([&] { load(write(tiff_file({many})), {{"grid", "phase"}}); }), "bad-labels");
}

TEST_F(Slices, IdsDoNotPassThroughFloats) {
  TiffPage p{2, 1};
  p.bits = 32;
  p.pixels = number_bytes<std::uint32_t>({16777217, 2147483647});
  EXPECT_EQ(numbers(load(write(tiff_file({p})), {{"grid", "id"}}), "id"), (Numbers{16777217, 2147483647}));
  EXPECT_EQ(numbers(load(folder / "a.tif", {{"grid", "id"}, {"intercept", "-1"}}), "id"),
            (Numbers{16777216, 2147483646}));
  p.pixels = number_bytes<std::uint32_t>({1, 2147483648});
  try {
    load(write(tiff_file({p})), {{"grid", "id"}});
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "bad-labels");
    EXPECT_NE(e.diagnostic().message.find("2147483648 at voxel (1, 0, 0)"), std::string::npos) << e.what();
  }
  TiffPage wide{1, 1};
  wide.bits = 64;
  wide.pixels = number_bytes<std::uint64_t>({18446744073709551615u});
  try {
    load(write(tiff_file({wide})));
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "bad-values");
    EXPECT_NE(e.diagnostic().message.find("18446744073709551615"), std::string::npos) << e.what();
  }
}

TEST_F(Slices, PagesAreSlicesWithoutThumbnails) {
  auto file = pages(3, "");
  TiffPage thumbnail{1, 1};
  thumbnail.pixels = "x";
  thumbnail.tags = {{254, {1}}};
  file.push_back(thumbnail);
  file.insert(file.begin(), thumbnail);
  EXPECT_EQ(numbers(load(write(tiff_file(file)))), (Numbers{0, 100, 1, 101, 2, 102}));
  // A thumbnail that refers to the picture.
  thumbnail.sub_pages = {pair(7, 8)};
  EXPECT_EQ(numbers(load(write(tiff_file({thumbnail})))), (Numbers{7, 8}));
}

TEST_F(Slices, ImageJStacksWithOneDirectory) {
  TiffPage p{2, 1};
  p.bits = 16;
  p.description = "ImageJ=1.53t\nimages=3\nslices=3\nunit=micron\nspacing=2.5\nloop=false\n";
  for (const bool big_endian : {false, true}) {
    p.pixels = number_bytes<std::uint16_t>({1, 2, 300, 400, 5, 6}, big_endian);
    EXPECT_EQ(numbers(load(write(tiff_file({p}, {big_endian})))), (Numbers{1, 2, 300, 400, 5, 6}));
  }
  p.pixels.resize(10);
  const auto failure = [&](const std::string& bytes) {
    try {
      load(write(bytes));
    } catch (const Error& e) {
      return e.diagnostic().code + ": " + e.diagnostic().message;
    }
    return std::string();
  };
  p.description.replace(p.description.find("images=3\nslices=3"), 17, "images=900\nslices=900");
  EXPECT_EQ(failure(tiff_file({p})).rfind("several-pages", 0), 0u) << failure(tiff_file({p}));
}

TEST_F(Slices, Hyperstacks) {
  const fs::path path =
      write(tiff_file(pages(12, "ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\n")));
  EXPECT_EQ(code_of([&] { load(path); }), "several-channels");
  EXPECT_EQ(code_of([&] { load(path, {{"channel", "1"}}); }), "several-pages");
  EXPECT_EQ(numbers(load(path, {{"channel", "2"}, {"page", "1"}})), (Numbers{1, 101, 3, 103, 5, 105}));
  EXPECT_EQ(numbers(load(path, {{"channel", "1"}, {"page", "2"}})), (Numbers{6, 106, 8, 108, 10, 110}));
  EXPECT_EQ(code_of([&] { load(path, {{"channel", "3"}, {"page", "1"}}); }), "bad-value");
  EXPECT_EQ(code_of([&] { load(path, {{"channel", "1"}, {"page", "3"}}); }), "bad-value");
  EXPECT_EQ(numbers(load(path, {{"order", "stored"}})).size(), 24u);
  // Counts that contradict the file are not guessed.
  const fs::path wrong =
      write(tiff_file(pages(4, "ImageJ=1.53t\nimages=6\nchannels=2\nslices=3\n")), "w.tif");
  EXPECT_EQ(code_of([&] { load(wrong); }), "several-pages");
  EXPECT_EQ(numbers(load(wrong, {{"order", "stored"}})).size(), 8u);
}

std::string ome(const std::string& size, const std::string& more) {
  return "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\" "
         "UUID=\"urn:1\">"
         "<Image ID=\"Image:0\"><Pixels Type=\"uint8\" SizeX=\"2\" SizeY=\"1\" " +
         size + "><Channel ID=\"0\" SamplesPerPixel=\"1\"/>" + more + "</Pixels></Image></OME>";
}

TEST_F(Slices, OmeTiff) {
  const std::string size = "SizeC=\"2\" SizeZ=\"3\" SizeT=\"1\"";
  const auto stack = [&](const std::string& text) { return write(tiff_file(pages(6, text)), "a.ome.tif"); };
  const auto second = [&](const fs::path& path) { return numbers(load(path, {{"channel", "2"}})); };
  const fs::path by_channel = stack(ome(size + " DimensionOrder=\"XYCZT\"", ""));
  EXPECT_EQ(code_of([&] { load(by_channel); }), "several-channels");
  EXPECT_EQ(second(by_channel), (Numbers{1, 101, 3, 103, 5, 105}));
  EXPECT_EQ(second(stack(ome(size + " DimensionOrder=\"XYZCT\"", "<TiffData/>"))),
            (Numbers{3, 103, 4, 104, 5, 105}));
  std::string each;
  for (int z = 0; z < 3; ++z)
    for (int c = 0; c < 2; ++c)
      each += "<TiffData IFD=\"" + std::to_string(5 - 2 * z - c) + "\" FirstZ=\"" + std::to_string(z) +
              "\" FirstC=\"" + std::to_string(c) + "\"/>";
  EXPECT_EQ(second(stack(ome(size + " DimensionOrder=\"XYZCT\"", each))), (Numbers{4, 104, 2, 102, 0, 100}));
  const std::string elsewhere = "<TiffData><UUID FileName=\"b.ome.tif\">urn:2</UUID></TiffData>";
  EXPECT_EQ(code_of([&] { second(stack(ome(size + " DimensionOrder=\"XYZCT\"", elsewhere))); }),
            "several-pages");
  EXPECT_EQ(code_of([&] { second(stack(ome(size, ""))); }), "several-pages") << "no order";
  EXPECT_EQ(code_of([&] {
              second(stack(ome("SizeC=\"2\" SizeZ=\"4\" SizeT=\"1\" DimensionOrder=\"XYZCT\"", "")));
            }),
            "several-pages");
}

TEST_F(Slices, SizesOfVoxelsThatOmeAndImageJState) {
  const std::string sizes =
      " PhysicalSizeX=\"2\" PhysicalSizeY=\"2\" PhysicalSizeZ=\"500\" PhysicalSizeZUnit=\"nm\"";
  const auto spacing = [&](const std::string& bytes) {
    return test::load_volume(write(bytes))
        .output<Volume>("volume")
        .find<openvdb::FloatGrid>("density")
        ->voxelSize();
  };
  EXPECT_TRUE(
      spacing(tiff_file(
                  pages(2, ome("SizeC=\"1\" SizeZ=\"2\" SizeT=\"1\" DimensionOrder=\"XYZCT\"" + sizes, ""))))
          .eq(openvdb::Vec3d(0.002, 0.002, 0.0005), 1e-9));
  EXPECT_EQ(code_of([&] { test::load_volume(write(tiff_file(pages(2, "")))); }), "no-spacing");
}

TEST_F(Slices, ShapesOfTifffile) {
  EXPECT_EQ(numbers(load(write(tiff_file(pages(2, "{\"shape\": [2, 1, 2]}"))))), (Numbers{0, 100, 1, 101}));
  TiffPage one = pair(0, 0, "{\"shape\": [2, 1, 2], \"truncated\": true}");
  one.pixels = {1, 2, 3, 4};
  EXPECT_EQ(numbers(load(write(tiff_file({one})))), (Numbers{1, 2, 3, 4}));
  const fs::path named = write(tiff_file(pages(4, "{\"shape\": [2, 2, 1, 2], \"axes\": \"ZCYX\"}")));
  EXPECT_EQ(numbers(load(named, {{"channel", "2"}})), (Numbers{1, 101, 3, 103}));
  EXPECT_EQ(code_of([&] { load(write(tiff_file(pages(4, "{\"shape\": [2, 2, 1, 2]}")))); }), "several-pages");
}

TEST_F(Slices, SharedFiles) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const fs::path reports = data / "reports";
  const auto white = numbers(load(reports / "miniswhite8.tif"));
  ASSERT_EQ(white.size(), 3200u);
  for (std::size_t z = 0; z < 10; ++z) EXPECT_EQ(white[320 * z + 7 * 20 + 9], 10.0 * double(z));
  for (const char* name : {"ij_2channels.tif", "ome_2channels.ome.tif"}) {
    EXPECT_EQ(code_of([&] { load(reports / name); }), "several-channels") << name;
    for (const char* channel : {"1", "2"}) {
      const auto stack = numbers(load(reports / name, {{"channel", channel}}));
      ASSERT_EQ(stack.size(), 1600u);
      for (std::size_t z = 1; z < 5; ++z) EXPECT_EQ(stack[320 * z + 169], stack[169] + double(z));
    }
  }
}

}  // namespace
}  // namespace terrazzo
