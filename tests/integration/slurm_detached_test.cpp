// Commands that leave everything to jobs, on a real Slurm.
#include "tests/integration/slurm_fixture.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;
using test::wait_until;

constexpr const char* file_text =
    "  file: {type: Export, inputs: {image: \"section[2].image\"}, params: {path: section.png}}\n";

constexpr const char* points_text = R"(terrazzo: 1
nodes:
  shape: {type: Shape, params: {kind: rock, count: 2}}
  sizes: {type: Distribution, params: {kind: lognormal, mean: 1, sd: 0.3, min: 0.5, max: 2, volume_fraction: 0.3}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {count: 100}}
)";

class SlurmDetached : public test::SlurmTest {
 protected:
  void write_inputs() override {
    std::ofstream(folder / "rounds.yaml") << kTwoRounds << file_text;
    std::ofstream(folder / "points.yaml") << points_text;
  }
  bool under_way() override {
    return wait_until(60, [&] { return status().at("points").at("done") >= 2; });
  }
  // Every point has the content that it has without Slurm.
  void expect_results() override {
    ASSERT_TRUE(fs::exists(folder / "out/sweep.csv"));
    const auto local = run_program({"sweep", (folder / "points.yaml").string(), "--vary", "pack.seed=1:24:1",
                                    "--out", (folder / "local").string(), "--cache",
                                    (folder / "local_cache").string(), "--jobs", "2", "--quiet"});
    ASSERT_EQ(local.exit_code, 0) << local.err;
    for (int i = 1; i <= 24; ++i) {
      const json expected = json::parse(*read_file(report_of(folder / "local", i)));
      const json found = json::parse(read_file(report_of(folder / "out", i)).value_or("{\"nodes\": []}"));
      ASSERT_EQ(found.at("nodes").size(), expected.at("nodes").size()) << i;
      for (std::size_t k = 0; k < expected.at("nodes").size(); ++k)
        EXPECT_EQ(found.at("nodes")[k].at("outputs"), expected.at("nodes")[k].at("outputs")) << i;
    }
  }

  ProgramRun command(std::vector<std::string> arguments, const std::vector<std::string>& more) {
    const std::vector<std::string> common = {"--out",        (folder / "out").string(),
                                             "--cache",      (folder / "cache").string(),
                                             "--executor",   "slurm",
                                             "--poll",       "0.3",
                                             "--chunk-size", "1"};
    arguments.insert(arguments.end(), common.begin(), common.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_on_cluster(arguments);
  }
  ProgramRun run(const std::vector<std::string>& more = {}) {
    return command({"run", (folder / "rounds.yaml").string()}, more);
  }
  ProgramRun sweep(const std::vector<std::string>& more = {}) {
    return command({"sweep", (folder / "points.yaml").string(), "--vary", "pack.seed=1:24:1"}, more);
  }
  std::string log(const std::string& role) {
    return read_file(folder / "out/jobs" / (role + ".txt")).value_or("");
  }
  // The job with this role that waits or runs, or null.
  json job(const std::string& role) {
    const json all = status();
    for (const auto& j : all.at("jobs"))
      if (j.at("role") == role) return j;
    return nullptr;
  }
  std::string coordinator() {
    json found;
    wait_until(30,
               [&] { return (found = job("coordinator")).is_object() && found.at("state") == "RUNNING"; });
    return found.is_object() ? found.at("task").get<std::string>() : "";
  }
  static bool handles_interrupts(pid_t process) {
    std::ifstream in("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(in, line);)
      if (line.starts_with("SigCgt:")) return std::stoull(line.substr(8), nullptr, 16) >> (SIGINT - 1) & 1;
    return false;
  }
  bool nothing_is_queued() {
    return wait_until(120, [&] { return cluster->queue().empty(); });
  }
};

TEST_F(SlurmDetached, ARunGoesThroughAllRoundsAndTheRest) {
  const auto detached = run({"--detach"});
  ASSERT_EQ(detached.exit_code, 0) << detached.err;
  EXPECT_NE(detached.err.find("job 1 coordinates"), std::string::npos) << detached.err;
  const auto again = run({"--detach"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("note: job 1 coordinates"), std::string::npos)
      << "it started a second one: " << again.err;
  ASSERT_TRUE(wait_until(120, [&] { return fs::exists(folder / "out/report.json"); })) << log("coordinator");
  ASSERT_TRUE(nothing_is_queued());
  EXPECT_NE(log("coordinator").find("round 2 of 2: 2 elements"), std::string::npos) << log("coordinator");
  EXPECT_TRUE(fs::exists(folder / "out/section.png"));
  const json report = json::parse(*read_file(folder / "out/report.json"));
  EXPECT_EQ(report.at("nodes").size(), 10u);
  for (const auto& node : report.at("nodes"))
    EXPECT_EQ(node.at("status") == "computed", node.at("name") == "file") << node.at("name");
  const auto shown = run_program({"status", (folder / "out").string()});
  EXPECT_NE(shown.out.find("the rest of the graph is done"), std::string::npos) << shown.out;
  EXPECT_EQ(status().at("failures"), json::array());
}

TEST_F(SlurmDetached, ACommandWaitsForTheJobThatStandsForIt) {
  ASSERT_EQ(sweep({"--detach"}).exit_code, 0);
  const auto waited = sweep();
  EXPECT_NE(waited.err.find("note: job 1 coordinates"), std::string::npos) << waited.err;
  EXPECT_NE(log("coordinator").find("[24/24]"), std::string::npos) << log("coordinator");
  EXPECT_EQ(waited.err.find("submitting"), std::string::npos) << waited.err;
  expect_completed(waited);
}

TEST_F(SlurmDetached, ACoordinatorWhoseNodeDiesIsStartedAgain) {
  ASSERT_EQ(sweep({"--detach"}).exit_code, 0);
  ASSERT_TRUE(under_way());
  const json job_now = job("coordinator");
  ASSERT_TRUE(job_now.is_object());
  cluster->kill_node(job_now.at("node"));
  ASSERT_TRUE(wait_until(180, [&] {
    cluster->start_again();
    return fs::exists(folder / "out/sweep.csv");
  })) << log("coordinator");
  EXPECT_EQ(count_events(folder / "out/jobs/coordinator.jsonl", "started"), 2);
  expect_results();
}

TEST_F(SlurmDetached, BeforeItsTimeLimitACoordinatorHandsOver) {
  ASSERT_EQ(sweep({"--detach"}).exit_code, 0);
  const std::string first = coordinator();
  ASSERT_FALSE(first.empty());
  ASSERT_TRUE(under_way());
  cluster->command({"scancel", "--batch", "--signal=USR1", first});  // as Slurm does before the limit
  ASSERT_TRUE(wait_until(120, [&] { return fs::exists(folder / "out/sweep.csv"); })) << log("coordinator");
  EXPECT_NE(log("coordinator").find("coordinates;"), std::string::npos)
      << "no other took over: " << log("coordinator");
  EXPECT_EQ(log("coordinator").find("canceled"), std::string::npos) << log("coordinator");
  expect_results();
}

TEST_F(SlurmDetached, CancelingTheCoordinatorCancelsTheSweep) {
  ASSERT_EQ(sweep({"--detach"}).exit_code, 0);
  auto waiting = std::async(std::launch::async, [&] { return sweep(); });
  ASSERT_TRUE(under_way());
  cluster->command({"scancel", coordinator()});
  const auto stopped = waiting.get();
  EXPECT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_NE(stopped.err.find("was canceled from outside"), std::string::npos) << stopped.err;
  ASSERT_TRUE(wait_until(20, [&] { return cluster->queue().empty(); })) << "its tasks go on";
  EXPECT_LT(status().at("points").at("done"), 24);
  const auto shown = run_on_cluster({"status", (folder / "out").string()});
  EXPECT_NE(shown.out.find("nothing is queued; the same command resumes"), std::string::npos) << shown.out;
  expect_completed(sweep());
}

TEST_F(SlurmDetached, AnInterruptWhileWaitingCancelsAll) {
  ASSERT_EQ(sweep({"--detach"}).exit_code, 0);
  ASSERT_TRUE(under_way());
  auto waiting = std::async(std::launch::async, [&] { return sweep(); });
  const std::string name = "terrazzo sweep .*--out " + (folder / "out").string() + " .*--chunk-size 1$";
  pid_t command = 0;
  ASSERT_TRUE(wait_until(60, [&] {
    command = process_of(name);
    return command > 0 && handles_interrupts(command);
  }));
  ::kill(command, SIGINT);
  const auto stopped = waiting.get();
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_TRUE(wait_until(20, [&] { return cluster->queue().empty(); }));
  expect_completed(sweep());
}

TEST_F(SlurmDetached, AChangedGraphIsRefused) {
  ASSERT_EQ(run({"--detach", "--slurm-coordinator", "--hold"}).exit_code, 0);
  const std::string held = job("coordinator").at("task");
  fs::rename(folder / "rounds.yaml", folder / "kept.yaml");
  std::ofstream(folder / "rounds.yaml")
      << kTwoRounds << file_text << "  more: {type: Shape, params: {kind: rock}}\n";
  const auto other = run();
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("for another command in"), std::string::npos) << other.err;
  cluster->command({"scontrol", "release", held});
  ASSERT_TRUE(nothing_is_queued());
  const json failures = status().at("failures");
  ASSERT_EQ(failures.size(), 1u) << failures;
  EXPECT_NE(failures[0].at("message").get<std::string>().find("rounds.yaml' has changed"), std::string::npos)
      << failures;
  EXPECT_FALSE(fs::exists(folder / "out/report.json"));
  fs::rename(folder / "kept.yaml", folder / "rounds.yaml");
  EXPECT_EQ(run().exit_code, 0);
}

}  // namespace
}  // namespace terrazzo
