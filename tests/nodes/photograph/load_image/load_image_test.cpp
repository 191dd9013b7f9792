#include <gtest/gtest.h>

#include <cstdlib>

#include "graph/diagnostic.h"
#include "nodes/common/io/image_file.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::code_of;

TEST(LoadImage, StackInTheOrderOfNames) {
  const auto folder = test::temporary_folder();
  for (const int i : {2, 0, 1})
    write_image(folder / ("s" + std::to_string(i) + ".exr"), Image(5, 4, 1, 1, Vec3f::Constant(0.25f * i)));
  const auto run =
      test::run_node("LoadImage", {}, {{"path", (folder / "s*.exr").string()}, {"pixel_size", "0.05"}});
  const auto& image = run.output<Image>("image");
  ASSERT_EQ(image.sections, 3);
  EXPECT_EQ(image.width, 5);
  EXPECT_EQ(image.height, 4);
  EXPECT_EQ(image.pixel_size, 0.05);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(image.at(4, 3, i)[1], 0.25f * i);
}

// Half of the picture is cut out; black would otherwise pass for material.
TEST(LoadImage, TellsOfTransparentPixels) {
  const std::string path = (test::temporary_folder() / "cut_out.png").string();
  std::vector<std::uint8_t> samples(4 * 2 * 4, 200);
  for (std::size_t i = 3; i < samples.size(); i += 8) samples[i] = 0;
  test::write_picture(path, {4, 2, 4, 3, Sample::UInt8, {}}, samples.data());
  const auto run = test::run_node("LoadImage", {}, {{"path", path}});
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_NE(run.warnings[0].find("50 % of the pixels are transparent"), std::string::npos) << run.warnings[0];
}

TEST(LoadImage, Errors) {
  const auto folder = test::temporary_folder();
  write_image(folder / "a1.png", Image(5, 4, 1, 1, Vec3f::Ones()));
  write_image(folder / "a2.png", Image(4, 5, 1, 1, Vec3f::Ones()));
  EXPECT_EQ(code_of([&] {
              test::run_node("LoadImage", {}, {{"path", (folder / "a*.png").string()}});
            }),
            "size-mismatch");
  const std::string one = (folder / "a1.png").string();
  EXPECT_EQ(code_of([&] {
              test::run_node("LoadImage", {}, {{"path", one}, {"colorspace", "nonsense"}});
            }),
            "unknown-colorspace");
  EXPECT_EQ(code_of([&] {
              test::run_node("LoadImage", {}, {{"path", one}, {"color_config", "another"}});
            }),
            "color-config");
  EXPECT_NE(code_of([&] { test::run_node("LoadImage", {}, {{"path", one}, {"pixel_size", "0"}}); }), "");
  EXPECT_NE(code_of([&] {
              test::run_node("LoadImage", {}, {{"path", (folder / "none.png").string()}});
            }),
            "");
}

}  // namespace
}  // namespace terrazzo
