// A solid of 256³ in 64 blocks on a real Slurm, and every fault while it is made. Disabled, because it takes
// 15 minutes: terrazzo_tests --gtest_also_run_disabled_tests --gtest_filter='*SlurmSolid.*'
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <future>
#include <iostream>
#include <nlohmann/json.hpp>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"
#include "tests/support/slurm_cluster.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::ProgramRun;
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

class DISABLED_SlurmSolid : public ::testing::Test {
 protected:
  void SetUp() override {
    cluster = std::make_unique<test::SlurmCluster>(folder / "slurm");
    if (!cluster->trouble().empty()) GTEST_SKIP() << cluster->trouble();
    std::ofstream(folder / "patterns.yaml") << wood_patterns_text;
    std::ofstream(folder / "solid.yaml") << wood_text;
    const auto made = run_program(
        {"run", (folder / "patterns.yaml").string(), "--out", folder.string(), "--no-cache", "--quiet"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  std::vector<std::string> command(std::vector<std::string> more = {}) {
    more.insert(more.begin(),
                {"run", (folder / "solid.yaml").string(), "--out", (folder / "out").string(), "--report",
                 (folder / "solid.json").string(), "--cache", (folder / "cache").string(), "--executor",
                 "slurm", "--poll", "1", "--chunk-size", "4"});
    return more;
  }
  ProgramRun run(const std::vector<std::string>& more = {}) {
    return run_program(command(more), {.environment = cluster->environment()});
  }
  std::future<ProgramRun> start(std::vector<std::string> more = {}) {
    begun = std::chrono::steady_clock::now();
    return std::async(std::launch::async, [this, more] { return run(more); });
  }
  std::size_t blocks() {
    std::size_t n = 0;
    for (int i = 1; i <= 64; ++i)
      n += fs::exists(folder / "out/elements-1" /
                      ("point-0" + std::string(i < 10 ? "0" : "") + std::to_string(i)) / "report.json");
    return n;
  }
  bool under_way() {
    return wait_until(120, [&] { return blocks() >= 3 && blocks() < 60 && !cluster->tasks().empty(); });
  }
  pid_t coordinator() {
    const auto found =
        test::run_command({"pgrep", "-f", "terrazzo run .*--out " + (folder / "out").string() + " "});
    return std::atoi(found.out.c_str());
  }
  void write_profile(const std::string& text) { std::ofstream(folder / "profile") << text; }
  std::vector<std::string> with_profile() { return {"--slurm-profile", (folder / "profile").string()}; }

  static std::map<std::string, json> contents(const fs::path& report) {
    std::map<std::string, json> out;
    const json all = json::parse(read_file(report).value_or("{\"nodes\": []}"));
    for (const auto& node : all.at("nodes"))
      for (const auto& [port, o] : node.at("outputs").items())
        out[node.at("name").get<std::string>() + "." + port] = o.at("content");
    return out;
  }
  // The content of every output, the joined volume's among them, is that of a run without Slurm.
  void expect_the_same_as_without_slurm() {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    std::cout << "  completed after " << seconds << " s\n";
    static std::map<std::string, json> expected;
    if (expected.empty()) {
      const auto local = run_program(
          {"run", (folder / "solid.yaml").string(), "--out", (folder / "local").string(), "--report",
           (folder / "local.json").string(), "--cache", (folder / "local_cache").string(), "--quiet"});
      ASSERT_EQ(local.exit_code, 0) << local.err;
      expected = contents(folder / "local.json");
      ASSERT_GE(expected.size(), 70u);
    }
    const auto found = contents(folder / "solid.json");
    EXPECT_EQ(found.size(), expected.size());
    for (const auto& [name, content] : expected) {
      const auto it = found.find(name);
      EXPECT_TRUE(it != found.end() && it->second == content) << name;
    }
    const auto verified =
        run_program({"cache", "verify", "--sample", "5", "--cache", (folder / "cache").string()});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  }
  fs::path folder = test::temporary_folder();
  std::unique_ptr<test::SlurmCluster> cluster;
  std::chrono::steady_clock::time_point begun;
};

TEST_F(DISABLED_SlurmSolid, WithoutAFault) {
  const auto done = start().get();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, Detached) {
  EXPECT_EQ(start({"--detach"}).get().exit_code, 0);
  ASSERT_TRUE(wait_until(300, [&] { return fs::exists(folder / "solid.json"); }));
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, ANodeDies) {
  auto command = start();
  ASSERT_TRUE(under_way());
  cluster->kill_node("n1");
  ASSERT_TRUE(wait_until(300, [&] {
    cluster->start_again();
    return command.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }));
  const auto done = command.get();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, ATaskIsKilled) {
  auto command = start();
  ASSERT_TRUE(under_way());
  ::kill(cluster->tasks().front(), SIGKILL);
  const auto done = command.get();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.err.find("; submitting it again"), std::string::npos) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, CanceledFromOutside) {
  auto command = start();
  ASSERT_TRUE(under_way());
  cluster->command({"scancel", "--me"});
  const auto stopped = command.get();
  EXPECT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_LT(blocks(), 64u);
  const auto done = run();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, TheControllerRestarts) {
  auto command = start();
  ASSERT_TRUE(under_way());
  cluster->kill_controller();
  std::this_thread::sleep_for(std::chrono::seconds(2));
  cluster->start_controller();
  const auto done = command.get();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, ATimeLimitIsReached) {
  auto command = start({"--slurm", "--time=1"});
  ASSERT_TRUE(under_way());
  ::kill(cluster->tasks().front(), SIGSTOP);  // it does nothing until its minute is over
  const auto done = command.get();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.err.find("ended (TIMEOUT)"), std::string::npos) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, ADiskIsFull) {
  write_profile("if [ $SLURMD_NODENAME = n1 ]; then trap '' XFSZ; ulimit -f 0; fi\n");
  const auto done = start(with_profile()).get();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.err.find("on n1 ended"), std::string::npos) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, AWorkerHasAnotherVersion) {
  // Stands for a node where another version is installed: it sees the round as planned by another version.
  const fs::path old = folder / "out/elements-1/old";
  std::ofstream(folder / "old.sh") << "#!/bin/bash\nmkdir -p " << old << "\nln -sfn ../jobs " << old / "jobs"
                                   << "\nsed 's/\"program\": .*/\"program\": \"0.0.1\",/' "
                                   << folder / "out/elements-1/sweep.json"
                                   << " >" << old / "sweep.json"
                                   << "\nexec " << test::build_folder() / "terrazzo"
                                   << " sweep-worker " << old / "sweep.json"
                                   << " \"${@:3}\"\n";
  fs::permissions(folder / "old.sh", fs::perms(0755));
  write_profile("TERRAZZO=" + (folder / "old.sh").string() + "\n");
  const auto refused = start(with_profile()).get();
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("but the sweep was planned with 0.0.1"), std::string::npos) << refused.err;
  EXPECT_EQ(blocks(), 0u);
  const auto done = run();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  expect_the_same_as_without_slurm();
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
  const auto done = run();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, TheCacheFolderVanishes) {
  auto command = start();
  ASSERT_TRUE(under_way());
  fs::rename(folder / "cache", folder / "gone");
  const auto done = command.get();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  std::cout << done.err;
  expect_the_same_as_without_slurm();
}

TEST_F(DISABLED_SlurmSolid, TheCoordinatorIsKilled) {
  auto command = start();
  ASSERT_TRUE(under_way());
  ASSERT_GT(coordinator(), 0);
  ::kill(coordinator(), SIGKILL);
  EXPECT_EQ(command.get().exit_code, 128 + SIGKILL);
  const auto done = run();
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.err.find("already queued"), std::string::npos) << done.err;
  expect_the_same_as_without_slurm();
}

}  // namespace
}  // namespace terrazzo
