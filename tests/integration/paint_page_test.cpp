// Tests the page of `terrazzo paint` in a browser, with mouse and keyboard.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/runtime/clients/studio/paint_picture.h"
#include "tests/support/program.h"
#include "tests/support/readers.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// The checker's folder with its package installed, kept in the build folder; empty if npm cannot install it.
fs::path checker() {
  const fs::path source = test::source_folder() / "tests/integration/paint_page";
  const fs::path folder = test::build_folder() / "paint_page";
  std::error_code error;
  fs::create_directories(folder, error);
  for (const char* name : {"package.json", "check.mjs"})
    fs::copy_file(source / name, folder / name, fs::copy_options::overwrite_existing, error);
  test::ProgramOptions here;
  here.folder = folder;
  if (test::run_command({"npm", "ls"}, here).exit_code != 0 &&
      test::run_command({"timeout", "120", "npm", "install", "--no-audit", "--no-fund", "--no-package-lock",
                         "--ignore-scripts"},
                        here)
              .exit_code != 0)
    return {};
  return folder;
}

TEST(PaintPage, PaintsUndoesSavesAndReplays) {
  for (const char* name : {"node", "npm"})
    if (test::run_command({"sh", "-c", std::string("command -v ") + name}).exit_code != 0)
      GTEST_SKIP() << name << " is not installed";
  const std::string browser = test::chromium();
  if (browser.empty()) GTEST_SKIP() << "chromium is not installed";
  const fs::path check = checker();
  if (check.empty()) GTEST_SKIP() << "npm cannot install playwright-core here";
  const fs::path folder = test::temporary_folder(), graph = folder / "saved.yaml";
  test::ProgramOptions here;
  here.folder = check;
  const auto run =
      test::run_command({"timeout", "100", "node", "check.mjs", (test::build_folder() / "terrazzo").string(),
                         test::paint_picture().string(), graph.string(), browser},
                        here);
  const auto r = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  EXPECT_EQ(r["errors"], nlohmann::json::array()) << run.err;
  EXPECT_EQ(r["exit_code"], 0);
  EXPECT_TRUE(r["without_nib"]["unchanged"]);
  for (const char* what : {"painted", "painted_again", "undone", "base_relative", "shows_what_is_served"})
    EXPECT_TRUE(r[what]) << what << run.out;
  EXPECT_GT(r["occupied"], 200);
  EXPECT_EQ(r["state"]["strokes"], 2);
  EXPECT_GE(r["corners"], 5);
  EXPECT_NE(std::string(r["outlined"]).find("an outline of"), std::string::npos) << r["outlined"];

  // The saved graph produces exactly the image that the page shows.
  const fs::path report = folder / "report.json";
  const auto replay = test::run_program({"run", graph.string(), "--no-cache", "--out",
                                         (folder / "out").string(), "--report", report.string(), "--quiet"});
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  std::string content;
  const auto told = nlohmann::json::parse(std::ifstream(report));
  for (const auto& n : told.at("nodes"))
    if (n.at("outputs").contains("image")) content = n["outputs"]["image"]["content"];
  EXPECT_EQ(content, r["state"]["content"]);
}

}  // namespace
}  // namespace terrazzo
