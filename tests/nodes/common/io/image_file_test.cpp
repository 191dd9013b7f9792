#include "nodes/common/io/image_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/color_config.h"
#include "nodes/common/texture/color.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::code_of;

Image noise(int width, int height) {
  Image image(width, height, 1, 1);
  Random random(3);
  for (auto& p : image.pixels)
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<float>(random.below(256)) / 255.0f;
      p[k] = srgb_to_linear(Vec3f::Constant(v))[0];
    }
  return image;
}

float largest_difference(const Image& a, const Image& b) {
  float d = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    d = std::max(d, (a.pixels[i] - b.pixels[i]).cwiseAbs().maxCoeff());
  return d;
}

void write_raw(const std::filesystem::path& path, int w, int h, int channels,
               const std::vector<std::uint8_t>& data, int orientation = 1) {
  PictureEncoding encoding{w, h, channels, -1, Sample::UInt8, {}};
  if (orientation != 1) encoding.attributes.emplace_back("Orientation", orientation);
  if (channels == 2 || channels == 4) {
    encoding.alpha = channels - 1;
    encoding.attributes.emplace_back("oiio:UnassociatedAlpha", 1);
  }
  test::write_picture(path, encoding, data.data());
}

// Sets $OCIO for a scope.
struct Environment {
  explicit Environment(const std::string& value) { setenv("OCIO", value.c_str(), 1); }
  ~Environment() { unsetenv("OCIO"); }
};

TEST(Color, SrgbRoundTripAndKnownValues) {
  for (int i = -50; i <= 300; ++i) {
    const float v = static_cast<float>(i) / 255.0f;
    EXPECT_NEAR(linear_to_srgb(srgb_to_linear(Vec3f::Constant(v)))[1], v, 2e-6);
  }
  EXPECT_NEAR(srgb_to_linear(Vec3f::Constant(0.5f))[0], 0.21404114, 1e-6);
  EXPECT_EQ(srgb_to_linear(Vec3f::Zero())[0], 0);
  EXPECT_NEAR(srgb_to_linear(Vec3f::Ones())[0], 1, 1e-7);
}

TEST(Color, OklabRoundTripAndKnownValues) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec3f c(random.uniform(0, 2), random.uniform(0, 2), random.uniform(0, 2));
    EXPECT_LT((oklab_to_linear(linear_to_oklab(c)) - c).cwiseAbs().maxCoeff(), 2e-5);
  }
  EXPECT_LT((linear_to_oklab(Vec3f::Ones()) - Vec3f(1, 0, 0)).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT((linear_to_oklab({1, 0, 0}) - Vec3f(0.62796f, 0.22486f, 0.12585f)).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(ImageFile, RoundTrips) {
  const Image image = noise(37, 23);
  const auto folder = test::temporary_folder();
  struct Case {
    const char* name;
    float tolerance;
  };
  for (const auto& [name, tolerance] : {Case{"a.exr", 0}, Case{"a.png", 1e-6f}, Case{"a.tif", 1e-4f}}) {
    write_image(folder / name, image, 0, "provenance");
    const Image back = read_image(folder / name, "auto", 0.25);
    ASSERT_EQ(back.width, 37);
    ASSERT_EQ(back.height, 23);
    EXPECT_EQ(back.pixel_size, 0.25);
    EXPECT_LE(largest_difference(image, back), tolerance) << name;
  }
}

TEST(ImageFile, DitherKeepsTheMeanBetweenLevels) {
  const float level = 100.3f / 255.0f;
  const Image flat(64, 64, 1, 1, srgb_to_linear(Vec3f::Constant(level)));
  const auto path = test::temporary_folder() / "flat.png";
  write_image(path, flat);
  double sum = 0;
  for (const auto& p : read_image(path).pixels) sum += linear_to_srgb(p)[0];
  EXPECT_NEAR(sum / (64 * 64) * 255, 100.3, 0.03);
}

TEST(ImageFile, GrayStaysGrayAndGrainIsNotDithered) {
  Image image(64, 64, 1, 1, srgb_to_linear(Vec3f::Constant(100.3f / 255.0f)));
  for (int y = 32; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      image.at(x, y) =
          srgb_to_linear(Vec3f::Constant((100.3f + 5 * static_cast<float>((x + y) % 2)) / 255.0f));
  const auto path = test::temporary_folder() / "gray.png";
  write_image(path, image);
  const Image back = read_image(path);
  for (const Vec3f& p : back.pixels) ASSERT_EQ(p.x(), p.z());
  for (int y = 33; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      ASSERT_NEAR(linear_to_srgb(back.at(x, y)).x() * 255, 100 + 5 * ((x + y) % 2), 0.01) << x << ", " << y;
}

TEST(ImageFile, GrayAlphaAndOrientation) {
  const auto folder = test::temporary_folder();
  write_raw(folder / "gray.png", 2, 1, 1, {0, 255});
  EXPECT_EQ(read_image(folder / "gray.png").at(1, 0), Vec3f(1, 1, 1));
  write_raw(folder / "alpha.png", 1, 1, 4, {255, 128, 0, 51});
  const Vec3f over_black = read_image(folder / "alpha.png").at(0, 0);
  EXPECT_NEAR(over_black[0], 0.2, 1e-6);
  EXPECT_NEAR(over_black[1], 0.2 * srgb_to_linear(Vec3f::Constant(128 / 255.0f))[0], 1e-6);
  // Orientation 6: the first row of the file is the right column of the upright image.
  write_raw(folder / "turned.tif", 3, 2, 1, {255, 0, 0, 0, 0, 0}, 6);
  const Image turned = read_image(folder / "turned.tif");
  ASSERT_EQ(turned.width, 2);
  ASSERT_EQ(turned.height, 3);
  EXPECT_EQ(turned.at(1, 0), Vec3f(1, 1, 1));
  EXPECT_EQ(turned.at(0, 0), Vec3f(0, 0, 0));
}

TEST(ImageFile, BadInput) {
  const auto folder = test::temporary_folder();
  EXPECT_EQ(code_of([&] { read_image(folder / "missing.png"); }), "unreadable-image");
  std::ofstream(folder / "broken.png") << "\x89PNG\r\n\x1a\nnothing";
  EXPECT_EQ(code_of([&] { read_image(folder / "broken.png"); }), "unreadable-image");
  std::ofstream(folder / "empty.jpg") << "";
  EXPECT_EQ(code_of([&] { read_image(folder / "empty.jpg"); }), "unreadable-image");
  Image bad(4, 4, 1, 1);
  bad.at(2, 3)[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(code_of([&] { write_image(folder / "nan.png", bad); }), "bad-pixels");
  bad.at(2, 3)[1] = std::numeric_limits<float>::infinity();
  write_image(folder / "inf.exr", bad);
  EXPECT_EQ(code_of([&] { read_image(folder / "inf.exr"); }), "bad-pixels");
  EXPECT_EQ(code_of([&] { write_image(folder / "none.png", Image()); }), "empty-image");
  EXPECT_EQ(code_of([&] { write_image(folder / "no" / "such" / "folder.png", noise(2, 2)); }),
            "unwritable-image");
  EXPECT_EQ(code_of([&] { write_image(folder / "a.what", noise(2, 2)); }), "unwritable-image");
}

TEST(ColorConfig, NamedSpaces) {
  const auto folder = test::temporary_folder();
  write_image(folder / "a.png", noise(16, 16));
  const Image automatic = read_image(folder / "a.png");
  EXPECT_LT(largest_difference(automatic, read_image(folder / "a.png", "sRGB")), 1e-5);
  EXPECT_LT(largest_difference(automatic, read_image(folder / "a.png", "sRGB - Texture")), 1e-5);
  Image encoded = read_image(folder / "a.png", "raw");
  for (auto& p : encoded.pixels) p = srgb_to_linear(p);
  EXPECT_LT(largest_difference(automatic, encoded), 1e-6);
  EXPECT_EQ(code_of([&] { read_image(folder / "a.png", "no such space"); }), "unknown-colorspace");
  EXPECT_EQ(color_config_id(), "built-in");
  for (const auto& name : colorspace_names()) {  // white is white in every color space
    Vec3f white = Vec3f::Ones();
    to_linear_rec709(&white, 1, 1, name);
    EXPECT_LT((white - Vec3f::Ones()).cwiseAbs().maxCoeff(), 1e-4) << name;
  }
}

TEST(ColorConfig, EnvironmentIsRespectedAndTold) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "c.ocio") << R"(ocio_profile_version: 2
roles: {default: mine, scene_linear: lin_rec709}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays: {d: [!<View> {name: v, colorspace: mine}]}
colorspaces:
  - !<ColorSpace> {name: lin_rec709}
  - !<ColorSpace>
    name: mine
    to_scene_reference: !<ExponentTransform> {value: [2, 2, 2, 1]}
)";
  const Environment environment((folder / "c.ocio").string());
  EXPECT_NE(color_config_id(), "built-in");
  Vec3f half = Vec3f::Constant(0.5f);
  to_linear_rec709(&half, 1, 1, "mine");
  EXPECT_NEAR(half[0], 0.25, 1e-5);
  half = Vec3f::Constant(0.5f);
  to_linear_rec709(&half, 1, 1, "sRGB");  // not in that configuration, so the built-in one is used
  EXPECT_NEAR(half[0], 0.21404, 1e-4);
}

TEST(ColorConfig, BrokenEnvironmentIsAnError) {
  const Environment environment("/no/such/config.ocio");
  EXPECT_EQ(color_config_id().rfind("unreadable", 0), 0u);
  Vec3f half = Vec3f::Constant(0.5f);
  EXPECT_EQ(code_of([&] { to_linear_rec709(&half, 1, 1, "sRGB"); }), "color-config");
}

}  // namespace
}  // namespace terrazzo
