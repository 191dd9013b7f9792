// Masks whose numbers other programs store in unusual ways, and masks that are no masks any more.
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/data/labels.h"
#include "nodes/photograph/load_labels/label_file.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/png_file.h"
#include "tests/support/run_node.h"
#include "tests/support/tiff_file.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using load_labels::RawMask;
using load_labels::read_mask;
using test::code_of;
using test::number_bytes;
using test::TiffPage;

using Numbers = std::vector<std::uint32_t>;

class StoredNumbers : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  Numbers numbers(const fs::path& path, const PageOptions& choice = {}) {
    warnings.clear();
    return read_mask(path, choice, {available_memory(), [&](const std::string& w) { warnings.push_back(w); }})
        .values;
  }
  static TiffPage row(int width, int bits, const std::string& pixels, int photometric = 1, int format = 1) {
    TiffPage p{width, 1};
    p.bits = bits;
    p.pixels = pixels;
    p.photometric = photometric;
    p.format = format;
    return p;
  }
  Numbers tiff(const TiffPage& p) { return numbers(write("a.tif", test::tiff_file({p}))); }
  Numbers png(int width, int depth, int kind, const std::string& rows, const std::string& chunks = {}) {
    return numbers(write("a.png", test::png_file({width, 1, depth, kind, rows, chunks})));
  }
  std::string failure(const std::function<void()>& f) {
    try {
      f();
    } catch (const Error& e) {
      return e.diagnostic().code + ": " + e.diagnostic().message;
    }
    return "";
  }
  fs::path folder = test::temporary_folder();
  std::vector<std::string> warnings;
};

TEST_F(StoredNumbers, Tiff) {
  EXPECT_EQ(tiff(row(3, 8, {0, 1, '\xff'}, 0)), (Numbers{0, 1, 255})) << "WhiteIsZero";
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("WhiteIsZero"), std::string::npos);
  EXPECT_EQ(tiff(row(4, 1, {'\x50'})), (Numbers{0, 1, 0, 1}));
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(tiff(row(4, 2, {'\x1b'})), (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(tiff(row(2, 4, {'\x3f'})), (Numbers{3, 15}));
  EXPECT_EQ(tiff(row(2, 32, number_bytes<std::uint32_t>({16777217, 4294967294u}))),
            (Numbers{16777217, 4294967294u}));
  EXPECT_EQ(tiff(row(2, 64, number_bytes<std::int64_t>({0, 2147483649}), 1, 2)), (Numbers{0, 2147483649}));
  EXPECT_EQ(tiff(row(2, 64, number_bytes<std::uint64_t>({7, 8}))), (Numbers{7, 8}));
  EXPECT_EQ(tiff(row(2, 64, number_bytes<double>({7, 16777217}), 1, 3)), (Numbers{7, 16777217}));
  TiffPage palette = row(4, 8, {0, 1, 2, 3}, 3);
  palette.tags = {{320, std::vector<std::uint32_t>(768, 0)}};  // all colors are equal
  EXPECT_EQ(tiff(palette), (Numbers{0, 1, 2, 3}));
}

TEST_F(StoredNumbers, NumbersBeyondAreRefusedWithTheirValue) {
  const auto message = [&](const TiffPage& p) { return failure([&] { tiff(p); }); };
  EXPECT_NE(message(row(1, 64, number_bytes<std::int64_t>({4294967296}), 1, 2)).find("4294967296"),
            std::string::npos);
  EXPECT_NE(message(row(1, 32, number_bytes<std::uint32_t>({4294967295u}))).find("4294967295"),
            std::string::npos);
  EXPECT_NE(message(row(1, 64, number_bytes<std::uint64_t>({9007199254740993u}))).find("9007199254740993"),
            std::string::npos);
  EXPECT_NE(message(row(1, 16, number_bytes<std::int16_t>({-2}), 1, 2)).find("-2"), std::string::npos);
}

TEST_F(StoredNumbers, Png) {
  EXPECT_EQ(png(8, 1, 0, {'\x50'}), (Numbers{0, 1, 0, 1, 0, 0, 0, 0}));
  EXPECT_EQ(png(4, 2, 0, {'\x1b'}), (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(png(2, 4, 0, {'\x3f'}), (Numbers{3, 15}));
  EXPECT_EQ(png(2, 16, 0, {1, 2, '\xff', '\xff'}), (Numbers{258, 65535}));
  // Colors of a palette may repeat, and one may be transparent.
  const std::string palette = test::png_chunk("PLTE", {0, 0, 0, 9, 9, 9, 9, 9, 9, 1, 2, 3});
  EXPECT_EQ(png(4, 8, 3, {0, 1, 2, 3}, palette), (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(png(4, 2, 3, {'\x1b'}, palette), (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(png(4, 8, 3, {0, 1, 2, 3}, palette + test::png_chunk("tRNS", {'\xff', '\xff', 0})),
            (Numbers{0, 1, 0, 3}));
  EXPECT_TRUE(warnings.empty());
  png(2, 8, 3, {0, 1}, test::png_chunk("PLTE", {9, 9, 9, 0, 0, 0}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("not black"), std::string::npos) << warnings[0];
}

TEST_F(StoredNumbers, OtherFormatsWithPalettesOrScaledNumbers) {
  const auto little = [](std::uint32_t v) { return number_bytes<std::uint32_t>({v}); };
  const std::string bmp = "BM" + little(0) + little(0) + little(54 + 16) + little(40) + little(4) +
                          little(1) + std::string{1, 0, 8, 0} + std::string(16, '\0') + little(4) +
                          little(0) + std::string(16, '\x40') + std::string{3, 0, 1, 2};
  EXPECT_EQ(numbers(write("a.bmp", bmp)), (Numbers{3, 0, 1, 2}));
  EXPECT_EQ(numbers(write("a.pgm", "P2\n# from 0 to 15\n3 1\n15\n0 3 15\n")), (Numbers{0, 3, 15}));
  EXPECT_EQ(numbers(write("a.pgm", "P5 3 1 15\n" + std::string{0, 3, 15})), (Numbers{0, 3, 15}));
  EXPECT_EQ(numbers(write("a.pgm", "P5 1 1 1000\n" + std::string{3, '\xe8'})), (Numbers{1000}));
  EXPECT_EQ(numbers(write("a.pbm", "P1 4 1 0110")), (Numbers{0, 1, 1, 0}));
  EXPECT_EQ(numbers(write("a.pbm", std::string("P4 4 1\n\x60"))), (Numbers{0, 1, 1, 0}));
  // 2 × 1 pixels with the indices 1 and 2: the codes clear, 1, 2 and end of 3 bits.
  const std::string gif = std::string("GIF89a\2\0\1\0\x81\0\0", 13) + std::string(12, '\x33') +
                          std::string("\x2c\0\0\0\0\2\0\1\0\0\2\2\x8c\x0a\0\x3b", 16);
  EXPECT_EQ(numbers(write("a.gif", gif)), (Numbers{1, 2}));
}

TEST_F(StoredNumbers, TheOrientationIsApplied) {
  TiffPage p{3, 1};
  p.pixels = {1, 2, 3};
  p.tags = {{274, {6}}};
  write("a.tif", test::tiff_file({p}));
  const RawMask turned = read_mask(folder / "a.tif");
  EXPECT_EQ(turned.width, 1);
  EXPECT_EQ(turned.height, 3);
  EXPECT_EQ(turned.values, (Numbers{1, 2, 3}));
  p.tags = {{274, {3}}};
  EXPECT_EQ(tiff(p), (Numbers{3, 2, 1}));
}

TEST_F(StoredNumbers, PagesAndChannelsAreChosen) {
  const fs::path path = write("a.tif", test::tiff_file({row(2, 8, {1, 2}), row(2, 8, {3, 4})}));
  EXPECT_EQ(failure([&] { numbers(path); }).rfind("several-pages", 0), 0u);
  EXPECT_EQ(numbers(path, {2, {}}), (Numbers{3, 4}));
  EXPECT_EQ(code_of([&] { numbers(path, {3, {}}); }), "bad-value");
  TiffPage two = row(2, 8, {1, 5, 2, 6});
  two.samples = 2;
  two.tags = {{338, {0}}};
  const fs::path channels = write("c.tif", test::tiff_file({two}));
  EXPECT_EQ(code_of([&] { numbers(channels); }), "several-channels");
  EXPECT_EQ(numbers(channels, {{}, 2}), (Numbers{5, 6}));
  EXPECT_EQ(code_of([&] { numbers(channels, {{}, 3}); }), "bad-value");
  const auto run = test::run_node("LoadLabels", {}, {{"path", channels.string()}, {"channel", "1"}});
  EXPECT_EQ(run.output<Labels>("labels").ids, (std::vector<std::int32_t>{1, 2}));
}

// A disk of 255 whose border pixels are averages of 2 × 2 or 4 × 4 samples.
std::vector<std::uint8_t> smooth_disk(int size, int samples) {
  std::vector<std::uint8_t> out;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      int inside = 0;
      for (int k = 0; k < samples * samples; ++k) {
        const double u = x + (k % samples + 0.5) / samples - size / 2.0;
        const double v = y + (k / samples + 0.5) / samples - size / 2.0;
        inside += u * u + v * v < size * size / 9.0;
      }
      out.push_back(static_cast<std::uint8_t>(255 * inside / (samples * samples)));
    }
  return out;
}

TEST_F(StoredNumbers, SmoothedMasksAreRefused) {
  for (const int samples : {1, 2, 4}) {
    const fs::path path = folder / "disk.png";
    test::write_picture(path, 40, 40, 1, Sample::UInt8, smooth_disk(40, samples));
    EXPECT_EQ(code_of([&] { numbers(path); }), samples == 1 ? "" : "blurred-mask") << samples;
  }
  // Grains that touch, some of them tiny, are labels.
  std::vector<std::uint8_t> grains(40 * 40);
  for (int i = 0; i < 1600; ++i)
    grains[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(1 + i % 40 / 8 + 5 * (i / 320));
  for (int k = 0; k < 8; ++k)
    grains[static_cast<std::size_t>(205 + 8 * k)] = static_cast<std::uint8_t>(100 + k);
  test::write_picture(folder / "grains.png", 40, 40, 1, Sample::UInt8, grains);
  EXPECT_EQ(code_of([&] { numbers(folder / "grains.png"); }), "");
}

TEST_F(StoredNumbers, NoiseOfALossyCompressionIsNoClass) {
  std::vector<std::uint8_t> noisy = smooth_disk(40, 1);
  for (std::size_t i = 0; i < noisy.size(); i += 23)
    noisy[i] = static_cast<std::uint8_t>(noisy[i] == 0 ? 1 + i % 3 : 254 - i % 3);
  const fs::path path = folder / "noisy.png";
  test::write_picture(path, 40, 40, 1, Sample::UInt8, noisy);
  const auto load = [&] { test::run_node("LoadLabels", {}, {{"path", path.string()}, {"kind", "classes"}}); };
  EXPECT_EQ(code_of(load), "blurred-mask");
}

TEST_F(StoredNumbers, LossyMasksAreRefused) {
  test::write_picture(folder / "a.jpg", 16, 16, 1, Sample::UInt8, std::vector<std::uint8_t>(256, 255));
  EXPECT_EQ(code_of([&] { numbers(folder / "a.jpg"); }), "lossy-mask");
}

TEST_F(StoredNumbers, SharedFiles) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const fs::path reports = data / "reports";
  const auto load = [&](const char* name, const char* kind) {
    return test::run_node("LoadLabels", {}, {{"path", (reports / name).string()}, {"kind", kind}})
        .output<Labels>("labels");
  };
  EXPECT_EQ(load("binary_miniswhite.tif", "classes").count(), 12);
  EXPECT_EQ(load("ids_palette_repeats.png", "instances").count(), 12);
  EXPECT_EQ(load("plain.png", "instances").count(), 12);
  EXPECT_EQ(code_of([&] { load("mask_jpeg.jpg", "classes"); }), "lossy-mask");
  const auto run = test::run_node("LoadLabels", {},
                                  {{"path", (reports / "plain.png").string()},
                                   {"classes", (reports / "classes_voc_palette.png").string()}});
  const auto& classes = run.output<Labels>("labels").classes;
  EXPECT_EQ(std::set<std::int32_t>(classes.begin(), classes.end()), (std::set<std::int32_t>{0, 1, 2}));
}

}  // namespace
}  // namespace terrazzo
