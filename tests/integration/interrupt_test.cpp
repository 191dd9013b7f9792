// Ctrl-C during a packing, on the command line.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::ProgramOptions;
using test::ProgramRun;

// A packing of so many particles that it still moves them when a signal comes after a second.
const char* const long_packing =
    "terrazzo: 1\n"
    "nodes:\n"
    "  stone: {type: Shape, params: {kind: sphere, size: 1}}\n"
    "  sizes: {type: Distribution, params: {kind: lognormal, mean: 1, sd: 0.2, min: 0.6, max: 1.6, "
    "volume_fraction: 0.72}}\n"
    "  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: stone.shapes}, "
    "params: {count: 20000, iterations: 1000000}}\n";

class CtrlC : public ::testing::Test {
 protected:
  fs::path folder = test::temporary_folder();
  fs::path graph = folder / "g.yaml", out = folder / "out";
  void SetUp() override { std::ofstream(graph) << long_packing; }

  // Runs until the packing is interrupted after particles have been moved: on a slow machine, the first
  // attempts may be too early.
  ProgramRun interrupted(const std::string& message, ProgramOptions options = {}) {
    ProgramRun r;
    for (const double after : {1.0, 2.0, 4.0, 8.0, 16.0, 32.0}) {
      options.interrupt_after = after;
      r = test::run_program({"run", graph.string(), "--no-cache", "--out", out.string()}, options);
      EXPECT_EQ(r.exit_code, 130) << r.err;
      if (r.err.find(message) != std::string::npos) return r;
    }
    ADD_FAILURE() << "not interrupted while particles move: " << r.err;
    return r;
  }
};

TEST_F(CtrlC, LeavesAPackingFromWhichARunContinues) {
  const ProgramRun r = interrupted("note: pack: interrupted; saved the packing so far");
  const fs::path file = out / "pack.interrupted.json";
  EXPECT_NE(r.err.find(file.string()), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("LoadParticles"), std::string::npos) << r.err;
  std::string resumed = long_packing;
  resumed += "  so_far: {type: LoadParticles, params: {path: out/pack.interrupted.json}}\n";
  resumed.replace(resumed.find("stone.shapes}, "), 15, "stone.shapes, start: so_far.particles}, ");
  std::ofstream(folder / "resumed.yaml") << resumed;
  const ProgramRun again = test::run_program({"run", (folder / "resumed.yaml").string(), "--no-cache",
                                              "--set", "pack.on_jam=shrink", "--set", "pack.iterations=50"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("packing_fraction"), std::string::npos) << again.out;
}

TEST_F(CtrlC, AFullDiskIsReported) {
  const ProgramRun r =
      interrupted("warning: pack: interrupted; cannot save its work", {.largest_file = 4096});
  EXPECT_NE(r.err.find("pack.interrupted.json': "), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("free some disk space"), std::string::npos) << r.err;
  EXPECT_TRUE(!fs::exists(out) || fs::is_empty(out));
}

TEST_F(CtrlC, AnUnwritableFolderIsReported) {
  std::ofstream(out) << "a file stands where the folder should be";
  const ProgramRun r = interrupted("warning: pack: interrupted; cannot save its work");
  EXPECT_NE(r.err.find(out.string()), std::string::npos) << r.err;
}

}  // namespace
}  // namespace terrazzo
