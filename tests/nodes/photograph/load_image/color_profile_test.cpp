// Color spaces that picture files state.
#include <gtest/gtest.h>
#include <lcms2.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/common/io/image_file.h"
#include "nodes/common/io/pictures/color_config.h"
#include "nodes/common/texture/color.h"
#include "runtime/files.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/png_file.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::code_of;
using test::png_chunk;
using test::png_number;

// An ICC profile with a power law; gray without primaries.
std::string icc(double exponent, const cmsCIExyYTRIPLE* primaries) {
  cmsToneCurve* curve = cmsBuildGamma(nullptr, exponent);
  const cmsCIExyY d65 = {0.3127, 0.3290, 1};
  cmsToneCurve* const curves[3] = {curve, curve, curve};
  cmsHPROFILE profile =
      primaries ? cmsCreateRGBProfile(&d65, primaries, curves) : cmsCreateGrayProfile(cmsD50_xyY(), curve);
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  cmsFreeToneCurve(curve);
  return bytes;
}

constexpr cmsCIExyYTRIPLE kAdobe = {{0.64, 0.33, 1}, {0.21, 0.71, 1}, {0.15, 0.06, 1}};
constexpr cmsCIExyYTRIPLE kRec709 = {{0.64, 0.33, 1}, {0.30, 0.60, 1}, {0.15, 0.06, 1}};

std::string png_profile(const std::string& profile) {
  std::string packed(compressBound(profile.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(profile.data()),
           profile.size());
  return png_chunk("iCCP", std::string("test\0\0", 6) + packed.substr(0, size));
}

class StatedColorSpaces : public ::testing::Test {
 protected:
  // The color of one pixel of 200, 100, 50.
  Vec3f rgb(const std::string& chunks, const std::string& colorspace = "auto") {
    write("a.png", test::png_file({1, 1, 8, 2, {'\xc8', '\x64', '\x32'}, chunks}));
    return read_image(folder / "a.png", colorspace).at(0, 0);
  }
  Vec3f as(const std::string& colorspace) { return rgb("", colorspace); }
  void write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
  }
  fs::path folder = test::temporary_folder();
};

double difference(const Vec3f& a, const Vec3f& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST_F(StatedColorSpaces, IccProfiles) {
  EXPECT_LT(difference(rgb(png_profile(icc(563.0 / 256, &kAdobe))), as("Adobe RGB")), 1e-3);
  EXPECT_GT(difference(as("Adobe RGB"), as("sRGB")), 0.05);
  EXPECT_LT(difference(rgb(png_profile(icc(1, &kRec709))), as("raw")), 1e-3);
  EXPECT_EQ(rgb(png_profile(icc(563.0 / 256, &kAdobe)), "sRGB"), as("sRGB")) << "the parameter overrides";
  const std::string profile = icc(1.8, nullptr);
  write("gray.png", test::png_file({1, 1, 8, 0, "\x80", png_profile(profile)}));
  const float gray = std::pow(128 / 255.0f, 1.8f);
  EXPECT_LT(difference(read_image(folder / "gray.png").at(0, 0), Vec3f::Constant(gray)), 1e-3);
}

TEST_F(StatedColorSpaces, AProfileOfSrgbChangesNothing) {
  cmsHPROFILE srgb = cmsCreate_sRGBProfile();
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(srgb, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(srgb, bytes.data(), &size);
  cmsCloseProfile(srgb);
  EXPECT_EQ(rgb(png_profile(bytes)), rgb(""));
}

TEST_F(StatedColorSpaces, ProfilesInJpegFiles) {
  const std::vector<std::uint8_t> pixels(16 * 16 * 3, 90);
  test::write_picture(folder / "a.jpg", 16, 16, 3, Sample::UInt8, pixels, {{"jpeg:subsampling", "4:4:4"}});
  const std::string jpeg = *read_file(folder / "a.jpg");
  const std::string body = std::string("ICC_PROFILE\0\1\1", 14) + icc(1, &kRec709);
  const std::string segment =
      "\xff\xe2" + png_number(static_cast<std::uint32_t>(body.size() + 2)).substr(2) + body;
  write("b.jpg", jpeg.substr(0, 2) + segment + jpeg.substr(2));
  EXPECT_NEAR(read_image(folder / "b.jpg").at(8, 8)[1], 90 / 255.0, 1e-3);
}

TEST_F(StatedColorSpaces, ExifOfCamerasThatWriteAdobeRgb) {
  const auto number = [](std::uint32_t v, int bytes) {
    const std::string big = png_number(v);
    return std::string(big.rbegin(), big.rbegin() + bytes);
  };
  const auto entry = [&](int tag, int type, int count, const std::string& value) {
    return number(static_cast<std::uint32_t>(tag), 2) + number(static_cast<std::uint32_t>(type), 2) +
           number(static_cast<std::uint32_t>(count), 4) + value;
  };
  const std::string exif = std::string("II*\0", 4) + number(8, 4) + number(1, 2) +
                           entry(34665, 4, 1, number(26, 4)) + number(0, 4) + number(2, 2) +
                           entry(0xa001, 3, 1, number(65535, 4)) + entry(0xa005, 4, 1, number(56, 4)) +
                           number(0, 4) + number(1, 2) + entry(1, 2, 4, std::string("R03\0", 4)) +
                           number(0, 4);
  EXPECT_LT(difference(rgb(png_chunk("eXIf", exif)), as("Adobe RGB")), 1e-3);
  const std::vector<std::uint8_t> pixels(16 * 16 * 3, 90);
  test::write_picture(folder / "a.jpg", 16, 16, 3, Sample::UInt8, pixels);
  const std::string jpeg = *read_file(folder / "a.jpg");
  const std::string body = std::string("Exif\0\0", 6) + exif;
  const std::string segment =
      "\xff\xe1" + png_number(static_cast<std::uint32_t>(body.size() + 2)).substr(2) + body;
  write("b.jpg", jpeg.substr(0, 2) + segment + jpeg.substr(2));
  EXPECT_NEAR(read_image(folder / "b.jpg").at(8, 8)[1], std::pow(90 / 255.0, 563.0 / 256), 1e-3);
}

TEST_F(StatedColorSpaces, ChunksOfPng) {
  const auto gamma = [](std::uint32_t v) { return png_chunk("gAMA", png_number(v)); };
  EXPECT_EQ(rgb(gamma(45455)), rgb("")) << "1/2.2 stands for sRGB";
  EXPECT_EQ(rgb(png_chunk("sRGB", std::string(1, '\0')) + gamma(100000)), rgb(""));
  EXPECT_LT(difference(rgb(gamma(100000)), as("raw")), 1e-4);
  EXPECT_LT(difference(rgb(gamma(55556)), as("Gamma 1.8 Rec.709")), 1e-3);
  std::string chromaticities;
  for (const std::uint32_t v : {31270u, 32900u, 64000u, 33000u, 21000u, 71000u, 15000u, 6000u})
    chromaticities += png_number(v);
  EXPECT_LT(difference(rgb(gamma(45471) + png_chunk("cHRM", chromaticities)), as("Adobe RGB")), 0.01);
  // P3 with sRGB's curve. It comes before an ICC profile.
  const std::string display_p3 = png_chunk("cICP", {12, 13, 0, 1});
  EXPECT_LT(difference(rgb(display_p3), as("Display P3")), 1e-3);
  EXPECT_LT(difference(rgb(display_p3 + png_profile(icc(1, &kRec709))), as("Display P3")), 1e-3);
  EXPECT_EQ(code_of([&] { rgb(png_chunk("cICP", {9, 16, 0, 1})); }), "bad-color-profile") << "PQ";
  EXPECT_EQ(rgb(png_chunk("cICP", {9, 16, 0, 1}), "sRGB"), as("sRGB"));
}

TEST_F(StatedColorSpaces, ChromaticitiesOfOpenExr) {
  write_image(folder / "a.exr", Image(1, 1, 1, 1, Vec3f(0.2f, 0.4f, 0.6f)));
  std::string exr = *read_file(folder / "a.exr");
  // After the magic number and the version.
  std::string value;
  for (const float v : {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f})
    value.append(reinterpret_cast<const char*>(&v), 4);
  const std::string attribute = std::string("chromaticities\0chromaticities\0\x20\0\0\0", 34) + value;
  EXPECT_EQ(exr.find("chromaticities"), std::string::npos);
  // The offsets of the blocks follow the header.
  const auto end = exr.find(std::string("screenWindowWidth\0float\0\4\0\0\0", 28));
  ASSERT_NE(end, std::string::npos);
  const std::size_t table = end + 28 + 4 + 1;
  std::uint64_t offset = 0;
  std::memcpy(&offset, &exr[table], 8);
  offset += attribute.size();
  std::memcpy(&exr[table], &offset, 8);
  write("b.exr", exr.substr(0, 8) + attribute + exr.substr(8));
  Vec3f expected(0.2f, 0.4f, 0.6f);
  to_linear_rec709(&expected, 1, 1, "ACEScg");
  EXPECT_LT(difference(read_image(folder / "b.exr").at(0, 0), expected), 2e-3);
}

TEST_F(StatedColorSpaces, ProfilesThatCannotBeUsed) {
  write_image(folder / "a.jpg", Image(16, 16, 1, 1, Vec3f(0.2f, 0.4f, 0.6f)));
  const std::string jpeg = *read_file(folder / "a.jpg");
  for (const std::string& profile : {icc(2.2, &kAdobe).substr(0, 200), icc(1.8, nullptr)}) {
    const std::string body = std::string("ICC_PROFILE\0\1\1", 14) + profile;
    const std::string segment =
        "\xff\xe2" + png_number(static_cast<std::uint32_t>(body.size() + 2)).substr(2) + body;
    write("b.jpg", jpeg.substr(0, 2) + segment + jpeg.substr(2));
    EXPECT_EQ(code_of([&] { read_image(folder / "b.jpg"); }), "bad-color-profile");
    EXPECT_EQ(code_of([&] { read_image(folder / "b.jpg", "sRGB"); }), "");
  }
}

TEST_F(StatedColorSpaces, SharedFile) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const Image image = read_image(data / "reports" / "adobergb.jpg");
  std::size_t blue = 0, orange = 0;
  for (const Vec3f& p : image.pixels) {
    const Vec3f v = 255 * linear_to_srgb(p.cwiseMax(0.0f).cwiseMin(1.0f));
    blue += difference(v, Vec3f(0, 35, 225)) < 2;
    orange += difference(v, Vec3f(224, 121, 53)) < 2;
  }
  EXPECT_GT(blue, 50u);
  EXPECT_GT(orange, 500u);
}

}  // namespace
}  // namespace terrazzo
