// If the system refuses a resource, the program prints one clear sentence and exits. It never aborts.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(Limits, ASweepIntoAFolderThatCannotBeWritten) {
  const fs::path folder = test::temporary_folder(), graph = folder / "g.yaml";
  std::ofstream(graph)
      << "terrazzo: 1\nnodes: {fat: {type: Pattern, params: {kind: fat, width: 8, height: 8}}}\n";
  std::ofstream(folder / "file") << "no folder";
  for (const char* jobs : {"1", "2", "4"}) {
    const auto r = test::run_program({"sweep", graph.string(), "--vary", "fat.seed=1:8:1", "--jobs", jobs,
                                      "--no-cache", "--out", (folder / "file" / "out").string()});
    EXPECT_EQ(r.exit_code, 1) << jobs << r.err;
    EXPECT_NE(r.err.find("cannot write"), std::string::npos) << jobs << r.err;
  }
}

// Searches between a limit at which libraries fail to load and one that suffices.
void expect_limits_to_be_said(const std::string& node) {
  const fs::path folder = test::temporary_folder(), graph = folder / "g.yaml";
  std::ofstream(graph) << "terrazzo: 1\nnodes: {node: " << node << "}\n";
  const auto run = [&](long megabytes) {
    test::ProgramOptions o;
    o.address_space = megabytes << 20;
    return test::run_command(
        {"timeout", "60", (test::build_folder() / "terrazzo").string(), "run", graph.string(), "--no-cache",
         "--threads", "2", "--out", (folder / "out").string()},
        o);
  };
  long low = 64, high = 4096;  // refused; enough
  ASSERT_EQ(run(high).exit_code, 0);
  std::vector<long> tried;
  while (high - low > 16) {
    const long middle = (low + high) / 2;
    (run(middle).exit_code == 0 ? high : low) = middle;
    tried.push_back(middle);
  }
  // Tests every few megabytes below the sufficient limit, where threads and buffers start to fail.
  for (long m = high - 4; m > std::max(64L, high - 250); m -= 30) tried.push_back(m);
  for (const long m : tried) {
    const auto r = run(m);
    if (r.exit_code == 0) continue;
    EXPECT_TRUE(r.exit_code == 1 || r.exit_code == 127) << m << " MB: " << r.exit_code << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << m << " MB: " << r.err;
    EXPECT_TRUE(r.exit_code == 127 || r.err.find("address space") != std::string::npos ||
                r.err.find("not enough memory") != std::string::npos)
        << m << " MB: " << r.err;
  }
}

TEST(Limits, TooLittleAddressSpaceIsSaid) {
  expect_limits_to_be_said("{type: Pattern, params: {kind: fat, width: 8, height: 8}}");
}

// The libraries for pictures are loaded later, while threads run.
TEST(Limits, TooLittleAddressSpaceForPicturesIsSaid) {
  expect_limits_to_be_said("{type: LoadImage, params: {path: '" +
                           (test::source_folder() / "graphs/samples/section.png").string() + "'}}");
}

}  // namespace
}  // namespace terrazzo
