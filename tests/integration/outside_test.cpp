// Builds nodes and programs outside the tree, against the files that `cmake --install` installs.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using test::run_command;

TEST(Outside, APluginAndAnEmbeddingProgramBuildAndRun) {
  const auto base = test::temporary_folder();
  const auto prefix = (base / "prefix").string(), build = (base / "build").string();
  const auto must = [](const test::ProgramRun& r) { ASSERT_EQ(r.exit_code, 0) << r.out << r.err; };
  std::string flags = "-DCMAKE_CXX_FLAGS=";
#ifdef TERRAZZO_SANITIZE  // libraries with a sanitizer need a program that starts it
  flags += "-fsanitize=" TERRAZZO_SANITIZE;
  const std::string suppressions =
      "-DSANITIZER_SUPPRESSIONS=" +
      (test::source_folder() / "tests/support/sanitizer_suppressions.cpp").string();
#else
  const std::string suppressions = "-DSANITIZER_SUPPRESSIONS=";
#endif
  must(run_command({"cmake", "--install", test::build_folder().string(), "--prefix", prefix}));
  must(run_command({"cmake", "-G", "Ninja", "-S",
                    (test::source_folder() / "tests/integration/outside").string(), "-B", build,
                    "-DCMAKE_PREFIX_PATH=" + prefix, "-DCMAKE_BUILD_TYPE=Release", flags, suppressions}));
  must(run_command({"cmake", "--build", build}));
  if (HasFatalFailure()) return;

  std::ofstream(base / "graph.yaml") << "terrazzo: 1\nnodes:\n  d: {type: Double, params: {value: 4}}\n";
  const std::vector<std::string> show = {
      prefix + "/bin/terrazzo", "show", (base / "graph.yaml").string(), "d", "--json", "--cache",
      (base / "cache").string()};
  const auto without = run_command(show);
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_NE(without.err.find("there is no node type 'Double'"), std::string::npos) << without.err;
  for (int twice = 0; twice < 2;
       ++twice) {  // computed, then read back from the disk cache with the plugin's codec
    const auto with = run_command(show, {.environment = "TERRAZZO_PLUGIN_PATH=" + build});
    EXPECT_EQ(with.exit_code, 0) << with.err;
    EXPECT_NE(with.out.find("\"value\": 8.0"), std::string::npos) << with.out;
  }
  std::ofstream(base / "broken.so") << "no library";
  const auto broken = run_command(
      show, {.environment = "TERRAZZO_PLUGIN_PATH=" + (base / "broken.so").string() + ":" + build});
  EXPECT_EQ(broken.exit_code, 0);
  EXPECT_NE(broken.err.find("broken.so"), std::string::npos) << broken.err;

  const auto embedded = run_command({build + "/embed"});
  EXPECT_EQ(embedded.exit_code, 0) << embedded.err;
  EXPECT_EQ(embedded.out, "12 4\n");
}

}  // namespace
}  // namespace terrazzo
