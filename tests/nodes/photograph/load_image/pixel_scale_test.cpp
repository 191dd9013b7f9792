#include <gtest/gtest.h>

#include <functional>

#include "nodes/common/io/image_file.h"
#include "tests/support/picture.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

// Writes a gray picture of 40 × 30 pixels with these attributes, and returns what LoadImage warns of.
std::string warning_of(const std::string& name, const std::function<void(PictureAttributes&)>& set,
                       const std::string& pixel_size = "1") {
  const auto path = (test::temporary_folder() / name).string();
  PictureAttributes attributes;
  set(attributes);
  test::write_picture(path, 40, 30, 3, Sample::UInt8, std::vector<std::uint8_t>(40 * 30 * 3, 128),
                      attributes);
  const auto run = test::run_node("LoadImage", {}, {{"path", path}, {"pixel_size", pixel_size}});
  EXPECT_EQ(run.output<Image>("image").pixel_size, std::stod(pixel_size)) << "never applied silently";
  EXPECT_LE(run.warnings.size(), 1u);
  return run.warnings.empty() ? "" : run.warnings[0];
}

void resolution(PictureAttributes& spec, float x, const char* unit) {
  spec.emplace_back("XResolution", x), spec.emplace_back("YResolution", x),
      spec.emplace_back("ResolutionUnit", unit);
}

TEST(PixelScale, IsOfferedFromAScan) {
  EXPECT_NE(warning_of("a.tif", [](auto& s) { resolution(s, 1200, "in"); }).find("set pixel_size: 0.0212"),
            std::string::npos);
  EXPECT_NE(warning_of("a.jpg", [](auto& s) { resolution(s, 500, "cm"); }).find("set pixel_size: 0.02"),
            std::string::npos);
  EXPECT_EQ(warning_of(
                "b.tif", [](auto& s) { resolution(s, 1200, "in"); }, "0.0212"),
            "")
      << "it is set already";
  for (const float habit : {72.0f, 96.0f, 300.0f})
    EXPECT_EQ(warning_of("c.tif", [&](auto& s) { resolution(s, habit, "in"); }), "") << habit;
  EXPECT_EQ(warning_of("d.png", [](auto&) {}), "");
}

TEST(PixelScale, IsOfferedFromImageJ) {
  const auto imagej = [](const char* description) {
    return warning_of("a.tif", [&](auto& s) {
      resolution(s, 4, "none");
      s.emplace_back("ImageDescription", description);
    });
  };
  EXPECT_NE(imagej("ImageJ=1.53t\nunit=micron\n").find("set pixel_size: 0.00025"), std::string::npos);
  EXPECT_NE(imagej("ImageJ=1.53t\nimages=1\nunit=mm\n").find("set pixel_size: 0.25"), std::string::npos);
  EXPECT_EQ(imagej("ImageJ=1.53t\nunit=pixel\n"), "");
  EXPECT_EQ(imagej("A photograph\nunit=mm\n"), "");
}

// A lens of 50 mm at 1050 mm from the subject reduces 20 times; a sensor of 36 mm is 40 pixels wide.
TEST(PixelScale, IsOfferedFromACamera) {
  const auto camera = [](PictureAttributes& s) {
    s.emplace_back("Exif:FocalLength", 50.0f);
    s.emplace_back("Exif:SubjectDistance", 1.05f);
    resolution(s, 350, "in");
  };
  EXPECT_NE(warning_of("a.jpg",
                       [&](auto& s) {
                         camera(s);
                         s.emplace_back("Exif:FocalLengthIn35mmFilm", 50);
                       })
                .find("set pixel_size: 18"),
            std::string::npos);
  const std::string plane = warning_of("b.jpg", [&](auto& s) {
    camera(s);
    s.emplace_back("Exif:FocalPlaneXResolution", 100.0f);
    s.emplace_back("Exif:FocalPlaneResolutionUnit", 3);
    s.emplace_back("Exif:PixelXDimension", 80);  // the picture was halved
  });
  EXPECT_NE(plane.find("set pixel_size: 4"), std::string::npos) << plane;
  EXPECT_EQ(warning_of("c.jpg", camera), "")
      << "neither pitch nor equivalent, and a camera's resolution is none";
}

}  // namespace
}  // namespace terrazzo
