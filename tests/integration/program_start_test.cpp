// Checks which libraries the program loads at startup: a hundred unneeded ones cost 0.1 s at every start.
#include <gtest/gtest.h>

#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

struct Start {
  int exit_code = 0;
  int libraries = 0;
  bool nodes = false, pictures = false;
};

// The libraries that glibc's loader reports.
Start start(const std::vector<std::string>& arguments) {
  const auto run = test::run_program(arguments, {.environment = "LD_DEBUG=files"});
  Start s{.exit_code = run.exit_code,
          .nodes = run.err.find("libterrazzo_nodes.so") != std::string::npos,
          .pictures = run.err.find("libOpenImageIO.so") != std::string::npos};
  for (std::size_t at = 0; (at = run.err.find("calling init: ", at)) != std::string::npos; ++at)
    ++s.libraries;
  return s;
}

TEST(ProgramStart, HelpAndUsageErrorsLoadNoNodes) {
  const std::vector<std::pair<std::vector<std::string>, int>> commands = {{{"--version"}, 0},
                                                                          {{"--help"}, 0},
                                                                          {{"run", "--help"}, 0},
                                                                          {{"paint", "--help"}, 0},
                                                                          {{}, 2},
                                                                          {{"no-such-thing"}, 2},
                                                                          {{"check"}, 2},
                                                                          {{"run", "a.yaml", "--wrong"}, 2},
                                                                          {{"paint"}, 2},
                                                                          {{"cache"}, 2}};
  for (const auto& [arguments, exit_code] : commands) {
    const Start s = start(arguments);
    std::string text = "terrazzo";
    for (const auto& a : arguments) text += " " + a;
    EXPECT_EQ(s.exit_code, exit_code) << text;
    EXPECT_FALSE(s.nodes) << text;
    EXPECT_GT(s.libraries, 3) << text << ": the loader reported no libraries, so this test is void";
    EXPECT_LT(s.libraries, 30) << text;
  }
}

TEST(ProgramStart, CommandsThatNeedNodesLoadThem) {
  const Start s = start({"nodes"});
  EXPECT_EQ(s.exit_code, 0);
  EXPECT_TRUE(s.nodes);
}

TEST(ProgramStart, OnlyPicturesLoadOpenImageIO) {
  const auto run = [&](const char* type) {
    return start({"run", (test::node_folder(type) / "example.yaml").string(), "--no-cache", "--quiet",
                  "--out", (test::temporary_folder() / "out").string()});
  };
  const Start shape = run("Shape"), image = run("LoadImage");
  EXPECT_EQ(shape.exit_code, 0);
  EXPECT_FALSE(shape.pictures);
  EXPECT_LT(shape.libraries, 120);
  EXPECT_EQ(image.exit_code, 0);
  EXPECT_TRUE(image.pictures);
}

}  // namespace
}  // namespace terrazzo
