// Tests the page of `terrazzo studio` in a browser, with mouse and keyboard.
#include <gtest/gtest.h>

#include "nodes/common/io/image_file.h"
#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(StudioPage, LooksEditsWiresUndoesAndSaves) {
  const std::string program = (test::build_folder() / "terrazzo").string();
  const fs::path folder = test::temporary_folder(), graph = folder / "graph.yaml";
  const auto page = test::run_command({program, "studio", (folder / "none.yaml").string()});
  if (page.err.find("without the page") != std::string::npos)
    GTEST_SKIP() << "the program was built without the page; ./dev studio builds it";
  const std::string browser = test::chromium();
  if (browser.empty()) GTEST_SKIP() << "chromium is not installed";
  const fs::path check = test::npm_check("studio_page");
  if (check.empty()) GTEST_SKIP() << "npm cannot install playwright-core and axe-core here";

  Image picture(60, 40, 1, 1, Vec3f(0.1f, 0.4f, 0.2f));
  write_image(folder / "a.png", picture);
  const std::string text =
      "# first\nterrazzo: 1\nname: Test\nnodes:\n  picture: {type: LoadImage, params: {path: a.png}}  # "
      "second\n"
      "  sheet:\n    type: ContactSheet\n    inputs: {images: picture.image}\n    params:\n      cell: 300  "
      "# third\n";
  write_text_atomically(graph, text);
  test::ProgramOptions here;
  here.folder = check;
  const auto run =
      test::run_command({"timeout", "100", "node", "check.mjs", program, graph.string(), browser}, here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  EXPECT_EQ(r["errors_before_end"], nlohmann::json::array()) << run.out;
  EXPECT_EQ(r["violations"], nlohmann::json::array());
  EXPECT_EQ(r["cards"], 2);
  EXPECT_EQ(r["address"].get<std::string>().find("token"), std::string::npos);
  EXPECT_NE(r["size_before"], r["size_after"]);
  std::string edited = text;
  edited.replace(edited.find("300"), 3, "100");
  EXPECT_EQ(r["text_after"], edited);
  EXPECT_EQ(r["line"], "  sheet:");
  EXPECT_EQ(r["broken_status"], "1 error in the graph");
  EXPECT_NE(r["message"].get<std::string>().find("ContactSheat"), std::string::npos);
  EXPECT_EQ(r["undone"], true);
  EXPECT_EQ(r["saved"], text + "  export:\n    type: Export\n    inputs: {image: sheet.image}\n");
  EXPECT_EQ(r["offered"], "Add a node that accepts Image");
  EXPECT_EQ(r["removed"], true);
  EXPECT_EQ(r["offline"], true);
}

}  // namespace
}  // namespace terrazzo
