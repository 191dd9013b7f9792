// Elements of repeated nodes on a real Slurm.
#include <map>

#include "tests/integration/slurm_fixture.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;
using test::wait_until;

// Eight blocks of 48³, joined, indexed and written, and the same solid made at once.
constexpr const char* solid_text = R"(terrazzo: 1
nodes:
  photo: {type: Pattern, params: {kind: fat, width: 48, height: 48}}
  base: {type: SolidBase, inputs: {exemplar: photo.image}, params: {size: 48, exemplar_size: 48, levels: 2, iterations: 1}}
  block: {type: SolidBlock, each: {k: "0:7:1"}, inputs: {base: base.base}, params: {blocks: 2, block: "${k}"}}
  joined: {type: JoinVolumes, inputs: {volumes: block.volume}}
  index: {type: BlockIndex, inputs: {volumes: block.volume}, params: {files: "solid_{}.vdb"}}
  list: {type: Export, inputs: {table: index.table}, params: {path: solid.csv}}
  file: {type: Export, each: {k: "0:7:1"}, inputs: {volume: "block[${k}].volume"}, params: {path: "solid_${k}.vdb"}}
  whole: {type: SolidOptimize, inputs: {exemplar: photo.image},
          params: {size: 48, exemplar_size: 48, levels: 2, iterations: 1, method: blockwise}}
)";

class SlurmElements : public test::SlurmTest {
 protected:
  void write_inputs() override { std::ofstream(folder / "solid.yaml") << solid_text; }
  bool under_way() override {
    return wait_until(60, [&] { return reports() >= 1 && reports() < 7 && !cluster->tasks().empty(); });
  }
  // The run took every block from the cache, and joined them to the solid that is made at once.
  void expect_results() override {
    const auto all = nodes();
    for (int k = 0; k < 8; ++k) {
      EXPECT_NE(all.at("block[" + std::to_string(k) + "]").at("status"), "computed") << k;
      EXPECT_TRUE(fs::exists(folder / "out" / ("solid_" + std::to_string(k) + ".vdb"))) << k;
    }
    EXPECT_EQ(all.at("joined").at("outputs").at("volume").at("content"),
              all.at("whole").at("outputs").at("volume").at("content"));
    const std::string list = read_file(folder / "out/solid.csv").value_or("");
    EXPECT_NE(list.find("7,solid_7.vdb,24,24,24,24,24,24"), std::string::npos) << list;
  }

  ProgramRun run(const std::string& graph, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"run",          (folder / graph).string(),
                                          "--out",        (folder / "out").string(),
                                          "--report",     (folder / "report.json").string(),
                                          "--cache",      (folder / "cache").string(),
                                          "--executor",   "slurm",
                                          "--poll",       "0.3",
                                          "--chunk-size", "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_on_cluster(arguments);
  }
  std::future<ProgramRun> start(std::vector<std::string> more = {}) {
    return std::async(std::launch::async, [this, more] { return run("solid.yaml", more); });
  }
  std::size_t reports() { return count_reports(folder / "out/elements-1", 8); }
  // How often the job for what all elements share has finished.
  int shared_jobs() { return count_events(folder / "out/elements-1/jobs/shared.jsonl", "finished"); }
  // The nodes of the last run's report by name.
  std::map<std::string, json> nodes() {
    std::map<std::string, json> out;
    const json report = json::parse(*read_file(folder / "report.json"));
    for (const auto& node : report.at("nodes")) out[node.at("name")] = node;
    return out;
  }
};

TEST_F(SlurmElements, AreTasksOfOneRun) {
  const auto done = run("solid.yaml");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("round 1 of 1: 8 elements"), std::string::npos) << done.out;
  EXPECT_NE(done.out.find("[8/8] block["), std::string::npos) << done.out;
  EXPECT_EQ(reports(), 8u);
  expect_results();
  // Computed once, before the blocks.
  EXPECT_NE(nodes().at("base").at("status"), "computed");
  const auto status = run_program({"status", (folder / "out").string()});
  EXPECT_EQ(status.out.find("8 points: 8 done"), 0u) << status.out;
  const auto log = run_program({"status", (folder / "out").string(), "--log", "block[3]"});
  EXPECT_EQ(log.out.find("=== point-004 started"), 0u) << log.out << log.err;
  // The same command submits nothing. Without the cache, the base and the blocks are computed again, on
  // Slurm.
  const auto again = run("solid.yaml");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(shared_jobs(), 1);
  const auto before = fs::last_write_time(folder / "out/elements-1/point-001/report.json");
  fs::remove_all(folder / "cache");
  const auto lost = run("solid.yaml");
  EXPECT_EQ(lost.exit_code, 0) << lost.err;
  EXPECT_GT(fs::last_write_time(folder / "out/elements-1/point-001/report.json"), before);
  EXPECT_EQ(shared_jobs(), 2);
  expect_results();
}

TEST_F(SlurmElements, SurviveAKilledTask) { expect_a_killed_task_runs_again(start()); }

// Also the blocks that were finished before are computed again, and not by the command itself.
TEST_F(SlurmElements, SurviveAVanishedCache) {
  auto command = start();
  ASSERT_TRUE(wait_until(60, [&] { return reports() >= 3 && reports() < 7; }));
  fs::rename(folder / "cache", folder / "gone");
  const auto done = command.get();
  EXPECT_NE(done.err.find("the cache has lost the results of"), std::string::npos) << done.err;
  expect_completed(done);
}

TEST_F(SlurmElements, CanceledFromOutsideTheSameCommandCompletesThem) {
  auto command = start();
  ASSERT_TRUE(under_way());
  cluster->command({"scancel", "--me"});
  const auto stopped = command.get();
  EXPECT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_NE(stopped.err.find("the rest of the graph was not run"), std::string::npos) << stopped.err;
  EXPECT_FALSE(fs::exists(folder / "out/solid.csv"));
  expect_completed(run("solid.yaml"));
}

TEST_F(SlurmElements, AfterAListAreASecondRound) {
  std::ofstream(folder / "packings.yaml") << kTwoRounds;
  const auto done = run("packings.yaml");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("round 1 of 2: 3 elements"), std::string::npos) << done.out;
  EXPECT_NE(done.out.find("round 2 of 2: 2 elements"), std::string::npos) << done.out;
  const auto spread = nodes();
  EXPECT_EQ(spread.size(), 9u);
  for (const auto& [name, node] : spread) EXPECT_NE(node.at("status"), "computed") << name;
  const auto local = run_program({"run", (folder / "packings.yaml").string(), "--report",
                                  (folder / "report.json").string(), "--no-cache", "--quiet"});
  ASSERT_EQ(local.exit_code, 0) << local.err;
  for (const auto& [name, node] : nodes())
    EXPECT_EQ(node.at("outputs"), spread.at(name).at("outputs")) << name;
}

// The interval of a photograph's property, from blocks and draws that are tasks.
TEST_F(SlurmElements, AreTheBlocksAndDrawsOfAProperty) {
  const std::string graph = (test::source_folder() / "graphs/library/property.yaml").string();
  const std::vector<std::string> small = {"--param", "blocks=2", "--param", "draws=2",
                                          "--param", "count=40", "--param", "resolution=16"};
  const auto done = run(graph, small);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("elements"), std::string::npos) << done.out;
  std::vector<std::string> local = {"run",     graph,   "--no-cache",
                                    "--quiet", "--out", (folder / "local").string()};
  local.insert(local.end(), small.begin(), small.end());
  const auto alone = run_program(local);
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  const auto table = read_file(folder / "out/property.csv");
  ASSERT_TRUE(table);
  EXPECT_EQ(table, read_file(folder / "local/property.csv"));
}

// A solid of phases in blocks that are tasks.
TEST_F(SlurmElements, AreTheBlocksOfASolidOfPhases) {
  std::ofstream(folder / "phases.yaml") << R"(terrazzo: 1
nodes:
  photo: {type: Pattern, params: {kind: marble, width: 96, height: 96}}
  base: {type: MediaBase, inputs: {image: photo.image}, params: {size: [24, 24, 288]}}
  block: {type: MediaBlock, each: {k: "0:2:1"}, inputs: {base: base.base}, params: {blocks: 3, block: "${k}"}}
  whole: {type: JoinVolumes, inputs: {volumes: block.volume}}
)";
  const auto done = run("phases.yaml");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("round 1 of 1: 3 elements"), std::string::npos) << done.out;
  const auto spread = nodes();
  const auto local = run_program({"run", (folder / "phases.yaml").string(), "--report",
                                  (folder / "report.json").string(), "--no-cache", "--quiet"});
  ASSERT_EQ(local.exit_code, 0) << local.err;
  for (const auto& [name, node] : nodes())
    EXPECT_EQ(node.at("outputs"), spread.at(name).at("outputs")) << name;
}

TEST_F(SlurmElements, ThatFailAreReportedAndNothingElseRuns) {
  std::ofstream(folder / "photos.yaml") << R"(terrazzo: 1
nodes:
  photo: {type: LoadImage, each: {k: [1, 2]}, params: {path: "photo_${k}.png"}}
  labels: {type: Segment, each: {k: [1, 2]}, inputs: {image: "photo[${k}].image"}, params: {method: clusters}}
)";
  fs::copy_file(test::source_folder() / "graphs/samples/section.png", folder / "photo_1.png");
  const auto failed = run("photos.yaml");
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_NE(failed.err.find("labels[2]: error: photo[2]: "), std::string::npos) << failed.err;
  EXPECT_NE(failed.err.find("1 of 2 elements failed"), std::string::npos) << failed.err;
  fs::copy_file(folder / "photo_1.png", folder / "photo_2.png");
  const auto done = run("photos.yaml");
  EXPECT_EQ(done.exit_code, 0) << done.err;
}

TEST_F(SlurmElements, AGraphWithoutThemIsAnError) {
  std::ofstream(folder / "one.yaml") << "terrazzo: 1\nnodes:\n  photo: {type: Pattern}\n";
  const auto none = run("one.yaml");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("the graph has none"), std::string::npos) << none.err;
  EXPECT_EQ(run("solid.yaml", {"--no-cache"}).exit_code, 2);
}

}  // namespace
}  // namespace terrazzo
