// `terrazzo run` without a graph.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

const std::vector<std::string> dry_run = {"run", "--dry-run", "--no-cache"};

// A copy of the program as it would be installed. Its libraries stay in the build folder.
fs::path installed_program() {
  const fs::path folder = test::temporary_folder();
  fs::create_directories(folder / "bin");
  fs::copy_file(test::build_folder() / "terrazzo", folder / "bin/terrazzo");
  return folder / "bin/terrazzo";
}

test::ProgramRun run_installed(const fs::path& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program.string());
  return test::run_command(arguments, {.folder = program.parent_path()});
}

TEST(GraphOmitted, UsesTheSourceTreeInABuildFolder) {
  const auto run = test::run_program(dry_run);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const fs::path graph = fs::canonical(test::source_folder()) / "graphs/materials/terrazzo.yaml";
  EXPECT_TRUE(run.out.starts_with("no graph given: using " + graph.string() + "; output folder: out\n"))
      << run.out;
}

TEST(GraphOmitted, UsesTheInstalledGraph) {
  const fs::path program = installed_program();
  const fs::path graphs =
      fs::canonical(program.parent_path().parent_path()) / "share/terrazzo/graphs/materials";
  fs::create_directories(graphs);
  std::ofstream(graphs / "terrazzo.yaml")
      << "terrazzo: 1\nnodes:\n  ball: {type: Shape, params: {kind: sphere}}\n";
  const auto run = run_installed(program, dry_run);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find((graphs / "terrazzo.yaml").string()), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("ball"), std::string::npos) << run.out;
}

TEST(GraphOmitted, FailsIfOnlyTheProgramIsInstalled) {
  const auto run = run_installed(installed_program(), dry_run);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("terrazzo run GRAPH"), std::string::npos) << run.err;
}

TEST(GraphOmitted, TextureRunsItsOwnGraph) {
  const std::string photo = (test::source_folder() / "graphs/samples/section.png").string();
  const auto run = test::run_program({"texture", photo, "--pixel-size", "0.2", "--finish", "honed", "--param",
                                      "relief=0.1", "--dry-run", "--no-cache"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("maps"), std::string::npos) << run.out;
  EXPECT_EQ(test::run_program({"texture"}).exit_code, 2);
  const auto wrong = test::run_program({"texture", photo, "--finish", "shiny", "--dry-run", "--no-cache"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("weathered"), std::string::npos) << wrong.err;
}

TEST(GraphOmitted, IsNotAnEmptyName) {
  const auto run = test::run_program({"run", "", "--dry-run", "--no-cache"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.out.find("no graph given"), std::string::npos);
}

}  // namespace
}  // namespace terrazzo
