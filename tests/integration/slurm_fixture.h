// What tests of commands on a real Slurm share: a cluster of their own, and faults while a command runs.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"
#include "tests/support/slurm_cluster.h"

namespace terrazzo::test {

class SlurmTest : public ::testing::Test {
 protected:
  using json = nlohmann::json;
  using ProgramRun = test::ProgramRun;
  // Stones, elements of a first round, are joined to one population, and packings of it are elements of a
  // second round.
  static constexpr const char* kTwoRounds = R"(terrazzo: 1
nodes:
  sizes: {type: Distribution, params: {kind: lognormal, mean: 1, sd: 0.3, min: 0.5, max: 2, volume_fraction: 0.3}}
  stone: {type: Shape, each: {s: [1, 2, 3]}, params: {kind: rock, seed: "${s}"}}
  stones: {type: MixShapes, inputs: {shapes: stone.shapes}}
  pack: {type: Anneal, each: {s: [1, 2]}, inputs: {distribution: sizes.distribution, shapes: stones.shapes},
         params: {count: 50, seed: "${s}"}}
  section: {type: Section, each: {s: [1, 2]}, inputs: {particles: "pack[${s}].particles", shapes: stones.shapes}}
)";

  void SetUp() override {
    cluster = std::make_unique<SlurmCluster>(folder / "slurm");
    if (!cluster->trouble().empty()) GTEST_SKIP() << cluster->trouble();
    write_inputs();
  }
  // The files that the commands read.
  virtual void write_inputs() = 0;
  // Waits until elements or points are being computed, while enough are left for a fault.
  virtual bool under_way() = 0;
  // The results are those of a run without Slurm.
  virtual void expect_results() = 0;

  ProgramRun run_on_cluster(const std::vector<std::string>& arguments) {
    return run_program(arguments, {.environment = cluster->environment()});
  }
  void expect_completed(const ProgramRun& done) {
    EXPECT_EQ(done.exit_code, 0) << done.err;
    expect_results();
  }

  json status() {
    const auto shown = run_on_cluster({"status", (folder / "out").string(), "--json"});
    EXPECT_EQ(shown.exit_code, 0) << shown.err;
    return json::parse(shown.out);
  }
  // The report of a point, from 1, below the folder of a sweep or of a round.
  static std::filesystem::path report_of(const std::filesystem::path& sweep, int point) {
    return sweep / fmt::format("point-{:03}", point) / "report.json";
  }
  static std::size_t count_reports(const std::filesystem::path& sweep, int points) {
    std::size_t n = 0;
    for (int i = 1; i <= points; ++i) n += std::filesystem::exists(report_of(sweep, i));
    return n;
  }
  // How often an event stands in the log of a job.
  static int count_events(const std::filesystem::path& log, const std::string& event) {
    std::istringstream lines(read_file(log).value_or(""));
    int n = 0;
    for (std::string line; std::getline(lines, line);) n += json::parse(line).at("event") == event;
    return n;
  }
  // The process whose command line matches the regular expression; 0: there is none.
  static pid_t process_of(const std::string& command) {
    return std::atoi(run_command({"pgrep", "-f", command}).out.c_str());
  }

  // What runs first in every job.
  std::vector<std::string> with_profile(const std::string& text) {
    std::ofstream(folder / "profile") << text;
    return {"--slurm-profile", (folder / "profile").string()};
  }
  // A program that stands for a node where another version is installed: it sees the sweep, or the round, in
  // this folder as planned by another version.
  std::filesystem::path write_old_program(const std::filesystem::path& sweep) {
    const auto old = sweep / "old", program = folder / "old.sh";
    std::ofstream(program) << "#!/bin/bash\nmkdir -p " << old << "\nln -sfn ../jobs " << old / "jobs"
                           << "\nsed 's/\"program\": .*/\"program\": \"0.0.1\",/' " << sweep / "sweep.json"
                           << " >" << old / "sweep.json"
                           << "\nexec " << build_folder() / "terrazzo"
                           << " sweep-worker " << old / "sweep.json"
                           << " \"${@:3}\"\n";
    std::filesystem::permissions(program, std::filesystem::perms(0755));
    return program;
  }
  // On n1, no file may grow, as on a full disk.
  std::vector<std::string> with_full_disk() {
    return with_profile("if [ $SLURMD_NODENAME = n1 ]; then trap '' XFSZ; ulimit -f 0; fi\n");
  }

  void expect_a_killed_task_runs_again(std::future<ProgramRun> command) {
    ASSERT_TRUE(under_way());
    ::kill(cluster->tasks().front(), SIGKILL);
    const auto done = command.get();
    EXPECT_NE(done.err.find("; submitting it again"), std::string::npos) << done.err;
    expect_completed(done);
  }
  void expect_a_dead_node_is_replaced(std::future<ProgramRun> command) {
    cluster->kill_node("n1");
    ASSERT_TRUE(wait_until(300, [&] {
      cluster->start_again();
      return command.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    }));
    expect_completed(command.get());
  }
  void expect_the_controller_may_restart(std::future<ProgramRun> command) {
    ASSERT_TRUE(under_way());
    cluster->kill_controller();
    std::this_thread::sleep_for(std::chrono::seconds(2));
    cluster->start_controller();
    expect_completed(command.get());
  }
  void expect_work_moves_from_a_full_disk(const ProgramRun& done) {
    EXPECT_NE(done.err.find("on n1 ended"), std::string::npos) << done.err;
    expect_completed(done);
  }

  const std::filesystem::path folder = temporary_folder();
  std::unique_ptr<SlurmCluster> cluster;
};

}  // namespace terrazzo::test
