// Files with several pictures, and pictures of kinds that cannot be read as they are meant.
#include <gtest/gtest.h>

#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/common/io/image_file.h"
#include "nodes/common/texture/color.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/png_file.h"
#include "tests/support/run_node.h"
#include "tests/support/tiff_file.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::code_of;
using test::tiff_file;
using test::TiffPage;

class PicturesInOneFile : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  // The encoded level, 0 to 255, of the first channel of pixel (0, 0).
  int level(const fs::path& path, const PageOptions& choice = {}) {
    const Image image = read_image(path, "auto", 1, {}, nullptr, choice);
    return static_cast<int>(std::lround(255 * linear_to_srgb(image.at(0, 0))[0]));
  }
  std::string failure(const fs::path& path, const PageOptions& choice = {}) {
    try {
      level(path, choice);
    } catch (const Error& e) {
      return e.diagnostic().code + ": " + e.diagnostic().message + " (" + e.diagnostic().hint + ")";
    }
    return "";
  }
  static TiffPage gray(int value, int photometric = 1) {
    TiffPage p{2, 1};
    p.photometric = photometric;
    p.pixels = {static_cast<char>(value), static_cast<char>(value)};
    return p;
  }
  fs::path folder = test::temporary_folder();
};

TEST_F(PicturesInOneFile, PagesAreNamedAndChosen) {
  const fs::path path = write("a.tif", tiff_file({gray(10), gray(20), gray(30)}));
  const std::string message = failure(path);
  EXPECT_EQ(message.rfind("several-pages", 0), 0u) << message;
  EXPECT_NE(message.find("3 pages of 2 × 1 pixels"), std::string::npos) << message;
  EXPECT_NE(message.find("from 1 to 3"), std::string::npos) << message;
  for (int page = 1; page <= 3; ++page) EXPECT_EQ(level(path, {page, {}}), 10 * page);
  EXPECT_EQ(failure(path, {4, {}}).rfind("bad-value", 0), 0u);
  const auto run = test::run_node("LoadImage", {}, {{"path", path.string()}, {"page", "2"}});
  EXPECT_NEAR(255 * linear_to_srgb(run.output<Image>("image").at(0, 0))[0], 20, 0.01);
}

TEST_F(PicturesInOneFile, ThumbnailsAreNoPages) {
  TiffPage thumbnail = gray(9);
  thumbnail.tags = {{254, {1}}};
  EXPECT_EQ(level(write("a.tif", tiff_file({thumbnail, gray(50)}))), 50);
  EXPECT_EQ(level(write("b.tif", tiff_file({gray(50), thumbnail}))), 50);
  thumbnail.sub_pages = {gray(70)};
  EXPECT_EQ(level(write("c.tif", tiff_file({thumbnail}))), 70);
  EXPECT_EQ(level(write("d.tif", tiff_file({gray(60, 0)}))), 255 - 60) << "what one sees";
}

TEST_F(PicturesInOneFile, StacksOfMicroscopes) {
  std::vector<TiffPage> pages;
  for (int i = 0; i < 6; ++i) pages.push_back(gray(10 * i));
  pages[0].description = "ImageJ=1.53t\nimages=6\nchannels=2\nslices=3\n";
  const fs::path path = write("a.tif", tiff_file(pages));
  EXPECT_NE(failure(path).find("2 channels × 3 slices (ImageJ)"), std::string::npos) << failure(path);
  EXPECT_EQ(level(path, {2, 1}), 20);
  EXPECT_EQ(level(path, {3, 2}), 50);
  TiffPage one = gray(0);
  one.pixels = {10, 10, 20, 20, 30, 30};
  one.description = "ImageJ=1.53t\nimages=3\nslices=3\n";
  EXPECT_EQ(failure(write("b.tif", tiff_file({one}))).rfind("several-pages", 0), 0u);
  EXPECT_EQ(level(folder / "b.tif", {1, {}}), 10);
  EXPECT_EQ(level(folder / "b.tif", {3, {}}), 30);
}

TEST_F(PicturesInOneFile, ChannelsThatAreNoColors) {
  TiffPage four{1, 1};
  four.samples = 4;
  four.pixels = {10, 20, 30, 40};
  four.tags = {{338, {0, 0, 0}}};
  const fs::path path = write("a.tif", tiff_file({four}));
  EXPECT_EQ(failure(path).rfind("several-channels", 0), 0u) << failure(path);
  EXPECT_EQ(level(path, {{}, 3}), 30);
  // Red, green, blue and near infrared.
  four.photometric = 2;
  four.tags = {{338, {0}}};
  const Image color = read_image(write("b.tif", tiff_file({four})));
  EXPECT_NEAR(255 * linear_to_srgb(color.at(0, 0))[2], 30, 0.01);
  EXPECT_EQ(level(folder / "b.tif", {{}, 4}), 40);
}

TEST_F(PicturesInOneFile, InkAndLabAreRefused) {
  TiffPage ink{1, 1};
  ink.samples = 4;
  ink.photometric = 5;
  ink.pixels = {10, 20, 30, 40};
  EXPECT_EQ(failure(write("a.tif", tiff_file({ink}))).rfind("unsupported-image", 0), 0u);
  TiffPage lab{1, 1};
  lab.samples = 3;
  lab.photometric = 8;
  lab.pixels = {10, 20, 30};
  EXPECT_EQ(failure(write("b.tif", tiff_file({lab}))).rfind("unsupported-image", 0), 0u);
}

TEST_F(PicturesInOneFile, AnimationsAreNotTheirFirstFrame) {
  const std::string control = test::png_number(2) + test::png_number(0);
  const std::string png = test::png_file({1, 1, 8, 0, "x", test::png_chunk("acTL", control)});
  EXPECT_NE(failure(write("a.png", png)).find("animated PNG of 2 frames"), std::string::npos);
  const std::string header =
      std::string("GIF89a\2\0\1\0\x81\0\0", 13) + std::string("\0\0\0\x40\x40\x40\x80\x80\x80", 9) + "xyz";
  const std::string frame("\x2c\0\0\0\0\2\0\1\0\0\2\2\x8c\x0a\0", 15);  // the colors 1 and 2
  EXPECT_EQ(level(write("one.gif", header + frame + ";")), 0x40);
  EXPECT_EQ(failure(write("two.gif", header + frame + frame + ";")).rfind("several-pages", 0), 0u);
  EXPECT_EQ(level(folder / "two.gif", {2, {}}), 0x40);
}

TEST_F(PicturesInOneFile, OtherFormatsAreNamed) {
  EXPECT_NE(failure(write("a.heic", std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(20, '\0')))
                .find("HEIC"),
            std::string::npos);
  EXPECT_NE(failure(write("a.webp", std::string("RIFF\x10\0\0\0WEBPVP8 ", 16))).find("WebP"),
            std::string::npos);
  EXPECT_NE(failure(write("a.psd", "8BPS" + std::string(30, '\0'))).find("Photoshop"), std::string::npos);
}

TEST_F(PicturesInOneFile, ThePngChunkOfExifHasAnOrientation) {
  const std::string exif("II*\0\x08\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0\0", 26);
  const Image turned =
      read_image(write("a.png", test::png_file({3, 1, 8, 0, "abc", test::png_chunk("eXIf", exif)})));
  EXPECT_EQ(turned.width, 1);
  EXPECT_EQ(turned.height, 3);
}

TEST_F(PicturesInOneFile, SharedFiles) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const fs::path reports = data / "reports";
  EXPECT_NE(failure(reports / "pages.tif").find("5 pages of 40 × 24 pixels"), std::string::npos);
  EXPECT_EQ(read_image(reports / "pages.tif", "auto", 1, {}, nullptr, {5, {}}).width, 40);
  // Its sensor data are compressed in a way that LibRaw does not know. The thumbnail is not the picture.
  EXPECT_NE(failure(reports / "photo.dng").find("raw file of a camera"), std::string::npos);
}

}  // namespace
}  // namespace terrazzo
