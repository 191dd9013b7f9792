// A solid of 256³ in 64 blocks on a real Slurm, and every fault while it is made. Disabled, because it takes
// 15 minutes: terrazzo_tests --gtest_also_run_disabled_tests --gtest_filter='*SlurmSolid.*'
#include <chrono>
#include <iostream>
#include <map>

#include "tests/integration/slurm_fixture.h"
#include "tests/support/report_contents.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;
using test::wait_until;

constexpr const char* wood_patterns_text = R"(terrazzo: 1
nodes:
  x: {type: Pattern, params: {kind: wood, axis: x, width: 64, height: 64}}
  y: {type: Pattern, params: {kind: wood, axis: y, width: 64, height: 64}}
  z: {type: Pattern, params: {kind: wood, axis: z, width: 64, height: 64}}
  fx: {type: Export, inputs: {image: x.image}, params: {path: x.png}}
  fy: {type: Export, inputs: {image: y.image}, params: {path: y.png}}
  fz: {type: Export, inputs: {image: z.image}, params: {path: z.png}}
)";

constexpr const char* wood_text = R"(terrazzo: 1
nodes:
  x: {type: LoadImage, params: {path: x.png}}
  y: {type: LoadImage, params: {path: y.png}}
  z: {type: LoadImage, params: {path: z.png}}
  base: {type: SolidBase, inputs: {exemplar: x.image, exemplar_y: y.image, exemplar_z: z.image},
         params: {size: 256, exemplar_size: 32, levels: 2, iterations: 1, finish: 0}}
  block: {type: SolidBlock, each: {k: "0:63:1"}, inputs: {base: base.base}, params: {blocks: 4, block: "${k}"}}
  joined: {type: JoinVolumes, inputs: {volumes: block.volume}}
  index: {type: BlockIndex, inputs: {volumes: block.volume}, params: {files: "solid_{}.vdb"}}
)";

class DISABLED_SlurmSolid : public test::SlurmTest {
 protected:
  void write_inputs() override {
    std::ofstream(folder / "patterns.yaml") << wood_patterns_text;
    std::ofstream(folder / "solid.yaml") << wood_text;
    const auto made = run_program(
        {"run", (folder / "patterns.yaml").string(), "--out", folder.string(), "--no-cache", "--quiet"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  bool under_way() override {
    return wait_until(120, [&] { return blocks() >= 3 && blocks() < 60 && !cluster->tasks().empty(); });
  }
  // The content of every output, the joined volume's among them, is that of a run without Slurm.
  void expect_results() override {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    std::cout << "  completed after " << seconds << " s\n";
    static std::map<std::string, std::string> expected;
    if (expected.empty()) {
      const auto local = run_program(
          {"run", (folder / "solid.yaml").string(), "--out", (folder / "local").string(), "--report",
           (folder / "local.json").string(), "--cache", (folder / "local_cache").string(), "--quiet"});
      ASSERT_EQ(local.exit_code, 0) << local.err;
      expected = test::report_contents(folder / "local.json");
      ASSERT_GE(expected.size(), 70u);
    }
    const auto found = test::report_contents(folder / "solid.json");
    EXPECT_EQ(found.size(), expected.size());
    for (const auto& [name, content] : expected) {
      const auto it = found.find(name);
      EXPECT_TRUE(it != found.end() && it->second == content) << name;
    }
    const auto verified =
        run_program({"cache", "verify", "--sample", "5", "--cache", (folder / "cache").string()});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  }

  std::vector<std::string> command(std::vector<std::string> more = {}) {
    more.insert(more.begin(),
                {"run", (folder / "solid.yaml").string(), "--out", (folder / "out").string(), "--report",
                 (folder / "solid.json").string(), "--cache", (folder / "cache").string(), "--executor",
                 "slurm", "--poll", "1", "--chunk-size", "4"});
    return more;
  }
  ProgramRun run(const std::vector<std::string>& more = {}) { return run_on_cluster(command(more)); }
  std::future<ProgramRun> start(std::vector<std::string> more = {}) {
    begun = std::chrono::steady_clock::now();
    return std::async(std::launch::async, [this, more] { return run(more); });
  }
  std::size_t blocks() { return count_reports(folder / "out/elements-1", 64); }
  pid_t coordinator() { return process_of("terrazzo run .*--out " + (folder / "out").string() + " "); }

  std::chrono::steady_clock::time_point begun;
};

TEST_F(DISABLED_SlurmSolid, WithoutAFault) { expect_completed(start().get()); }

TEST_F(DISABLED_SlurmSolid, Detached) {
  EXPECT_EQ(start({"--detach"}).get().exit_code, 0);
  ASSERT_TRUE(wait_until(300, [&] { return fs::exists(folder / "solid.json"); }));
  expect_results();
}

TEST_F(DISABLED_SlurmSolid, ANodeDies) {
  auto command = start();
  ASSERT_TRUE(under_way());
  expect_a_dead_node_is_replaced(std::move(command));
}

TEST_F(DISABLED_SlurmSolid, ATaskIsKilled) { expect_a_killed_task_runs_again(start()); }

TEST_F(DISABLED_SlurmSolid, CanceledFromOutside) {
  auto command = start();
  ASSERT_TRUE(under_way());
  cluster->command({"scancel", "--me"});
  const auto stopped = command.get();
  EXPECT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_LT(blocks(), 64u);
  expect_completed(run());
}

TEST_F(DISABLED_SlurmSolid, TheControllerRestarts) { expect_the_controller_may_restart(start()); }

TEST_F(DISABLED_SlurmSolid, ATimeLimitIsReached) {
  auto command = start({"--slurm", "--time=1"});
  ASSERT_TRUE(under_way());
  ::kill(cluster->tasks().front(), SIGSTOP);  // it does nothing until its minute is over
  const auto done = command.get();
  EXPECT_NE(done.err.find("ended (TIMEOUT)"), std::string::npos) << done.err;
  expect_completed(done);
}

TEST_F(DISABLED_SlurmSolid, ADiskIsFull) {
  expect_work_moves_from_a_full_disk(start(with_full_disk()).get());
}

TEST_F(DISABLED_SlurmSolid, AWorkerHasAnotherVersion) {
  const fs::path old = write_old_program(folder / "out/elements-1");
  const auto refused = start(with_profile("TERRAZZO=" + old.string() + "\n")).get();
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("but the sweep was planned with 0.0.1"), std::string::npos) << refused.err;
  EXPECT_EQ(blocks(), 0u);
  expect_completed(run());
}

TEST_F(DISABLED_SlurmSolid, AnInputFileChanges) {
  auto command = start();
  ASSERT_TRUE(under_way());
  fs::rename(folder / "x.png", folder / "kept.png");
  fs::copy_file(folder / "y.png", folder / "x.png");
  const auto refused = command.get();
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("x.png' has changed since the sweep was planned"), std::string::npos)
      << refused.err;
  fs::rename(folder / "kept.png", folder / "x.png");
  expect_completed(run());
}

TEST_F(DISABLED_SlurmSolid, TheCacheFolderVanishes) {
  auto command = start();
  ASSERT_TRUE(under_way());
  fs::rename(folder / "cache", folder / "gone");
  const auto done = command.get();
  std::cout << done.err;
  expect_completed(done);
}

TEST_F(DISABLED_SlurmSolid, TheCoordinatorIsKilled) {
  auto command = start();
  ASSERT_TRUE(under_way());
  ASSERT_GT(coordinator(), 0);
  ::kill(coordinator(), SIGKILL);
  EXPECT_EQ(command.get().exit_code, 128 + SIGKILL);
  const auto done = run();
  EXPECT_NE(done.err.find("already queued"), std::string::npos) << done.err;
  expect_completed(done);
}

}  // namespace
}  // namespace terrazzo
