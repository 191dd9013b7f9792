// Sweeps on a real Slurm: a controller and three nodes on this machine. Every fault must leave the results as
// they are without it.
#include <map>

#include "runtime/hash.h"
#include "tests/integration/slurm_fixture.h"
#include "tests/support/report_contents.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;
using test::wait_until;

constexpr const char* graph_text = R"(terrazzo: 1
nodes:
  shape: {type: Shape, params: {kind: rock, count: 2}}
  sizes: {type: Distribution, params: {kind: lognormal, mean: 1, sd: 0.3, min: 0.5, max: 2, volume_fraction: 0.3}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {count: 100}}
  photo: {type: LoadImage, params: {path: photo.png}}
  voxels: {type: Voxelize, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {resolution: 16}}
  section: {type: Section, inputs: {particles: pack.particles, shapes: shape.shapes}}
  grids: {type: Export, inputs: {volume: voxels.volume}, params: {path: grids.vdb}}
)";

class Slurm : public test::SlurmTest {
 protected:
  void write_inputs() override {
    std::ofstream(folder / "graph.yaml") << graph_text;
    fs::copy_file(test::source_folder() / "graphs/samples/section.png", folder / "photo.png");
  }
  bool under_way() override {
    return wait_until(60, [&] { return reports() >= 1 && reports() < 20 && !cluster->tasks().empty(); });
  }
  // The results without Slurm come from a cache that the processes of all these tests share.
  void expect_results() override {
    const auto local = sweep("local", local_cache().string(), {"--jobs", "2", "--quiet"});
    EXPECT_EQ(local.exit_code, 0) << local.err;
    const auto expected = contents("local");
    EXPECT_EQ(expected.size(), 24u * 12) << "every output of every point";
    EXPECT_EQ(contents("out"), expected);
    EXPECT_EQ(table("out"), table("local"));
    const auto verified =
        run_program({"cache", "verify", "--sample", "20", "--cache", (folder / "cache").string()});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  }

  // A sweep of 24 points, with more arguments. `out`, `cache`: below the test's folder, or absolute.
  ProgramRun sweep(const std::string& out, const std::string& cache, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "sweep",   (folder / "graph.yaml").string(), "--vary", "pack.seed=1:12:1",
        "--vary",  "voxels.resolution=16,20",        "--out",  (folder / out).string(),
        "--cache", (folder / cache).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_on_cluster(arguments);
  }
  ProgramRun on_slurm(std::vector<std::string> more = {}, const char* chunk_size = "3") {
    more.insert(more.begin(), {"--executor", "slurm", "--poll", "0.3", "--chunk-size", chunk_size});
    return sweep("out", "cache", more);
  }
  std::future<ProgramRun> start(std::vector<std::string> more = {}, const char* chunk_size = "3") {
    return std::async(std::launch::async, [this, more, chunk_size] { return on_slurm(more, chunk_size); });
  }

  // The cache of local runs of this build of the program. Those of other builds are removed.
  static fs::path local_cache() {
    std::string build;
    for (const char* file : {"terrazzo", "libterrazzo_graph.so", "libterrazzo_runtime.so",
                             "libterrazzo_nodes.so", "libterrazzo_pictures.so", "libterrazzo_studio.so"})
      build += std::to_string(fs::last_write_time(test::build_folder() / file).time_since_epoch().count());
    const fs::path caches = test::build_folder() / "slurm_local_cache", own = caches / hash_of(build).text();
    fs::create_directories(own);
    for (const auto& e : fs::directory_iterator(caches))
      if (std::error_code gone; e.path() != own) fs::remove_all(e.path(), gone);
    return own;
  }

  // Content hash of every output of every point.
  std::map<std::string, std::string> contents(const std::string& out) {
    std::map<std::string, std::string> found;
    for (int i = 1; i <= 24; ++i) {
      const fs::path report = report_of(folder / out, i), point = report.parent_path();
      if (!fs::exists(report)) continue;
      for (const auto& [output, content] : test::report_contents(report))
        found[point.filename().string() + "." + output] = content;
      EXPECT_TRUE(fs::exists(point / "grids.vdb")) << point;
    }
    return found;
  }
  // sweep.csv without the seconds.
  std::string table(const std::string& out) {
    std::ifstream in(folder / out / "sweep.csv");
    std::string text;
    for (std::string line; std::getline(in, line);) {
      std::size_t cell = 0;
      for (std::size_t at = 0; at <= line.size(); ++cell) {
        const auto end = std::min(line.find(',', at), line.size());
        if (cell != 4) text += line.substr(at, end - at) + ",";
        at = end + 1;
      }
      text += "\n";
    }
    return text;
  }
  std::size_t reports() { return count_reports(folder / "out", 24); }
  unsigned long newest_job() {
    unsigned long newest = 0;
    std::istringstream lines(cluster->command({"squeue", "-h", "-t", "all", "-o", "%F"}).out);
    for (std::string line; std::getline(lines, line);) newest = std::max(newest, std::stoul(line));
    return newest;
  }
  pid_t coordinator() { return process_of("sweep .*--out " + (folder / "out").string() + " "); }
};

TEST_F(Slurm, GivesTheResultsOfALocalRunAndStatusTellsAboutThem) {
  auto run = start({"--slurm", "--comment='two words'", "--parallel", "5"});
  ASSERT_TRUE(under_way());
  const json running = status();
  EXPECT_EQ(running.at("points").at("all"), 24);
  EXPECT_FALSE(running.at("tasks").empty());
  for (const auto& comment : cluster->queue("%k")) EXPECT_EQ(comment, "two words");
  EXPECT_LE(cluster->tasks().size(), 5u);
  const auto done = run.get();
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("[24/24] "), std::string::npos) << done.out;
  expect_results();
  const json end = status();
  EXPECT_EQ(end.at("points").at("done"), 24);
  EXPECT_EQ(end.at("failures"), json::array());
  EXPECT_EQ(end.at("seconds_left"), 0);
  const auto log = run_program({"status", (folder / "out").string(), "--log", "point-005"});
  EXPECT_EQ(log.out.find("=== point-005 started\n=== point-005 done"), 0u) << log.out << log.err;
  // Computed once, before the points.
  for (int i = 1; i <= 24; ++i) {
    const json report = json::parse(*read_file(report_of(folder / "out", i)));
    EXPECT_EQ(report.at("nodes").size(), 7u);
    for (const auto& node : report.at("nodes")) {
      const std::string name = node.at("name");
      const bool shared = name == "shape" || name == "sizes" || name == "photo";
      EXPECT_FALSE(shared && node.at("status") == "computed") << i << " " << name;
    }
  }
  // The same command reads the results and submits nothing. It works without Slurm.
  cluster.reset();
  const auto again = run_program({"sweep", (folder / "graph.yaml").string(), "--vary", "pack.seed=1:12:1",
                                  "--vary", "voxels.resolution=16,20", "--out", (folder / "out").string(),
                                  "--cache", (folder / "cache").string(), "--executor", "slurm"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("[24/24] "), std::string::npos) << again.out;
}

// The blocks of a solid as points of a sweep; then one run joins them.
TEST_F(Slurm, MakesTheElementsOfANodeThatOneRunJoins) {
  const std::string graph = (folder / "solid.yaml").string();
  std::ofstream(graph) << R"(terrazzo: 1
parameters: {wanted: {type: text, default: "0:7:1", doc: Blocks to make}}
nodes:
  photo: {type: Pattern, params: {kind: fat, width: 48, height: 48}}
  base: {type: SolidBase, inputs: {exemplar: photo.image}, params: {size: 32, exemplar_size: 48, levels: 2, iterations: 1}}
  block: {type: SolidBlock, each: {k: "${wanted}"}, inputs: {base: base.base}, params: {blocks: 2, block: "${k}"}}
  joined: {type: JoinVolumes, inputs: {volumes: block.volume}}
  whole: {type: SolidOptimize, inputs: {exemplar: photo.image},
          params: {size: 32, exemplar_size: 48, levels: 2, iterations: 1, method: blockwise}}
)";
  const std::string cache = (folder / "cache").string();
  const auto swept = run_on_cluster({"sweep", graph, "--vary", "wanted=0:7:1", "--target", "block", "--out",
                                     (folder / "out").string(), "--cache", cache, "--executor", "slurm",
                                     "--poll", "0.3", "--chunk-size", "3"});
  ASSERT_EQ(swept.exit_code, 0) << swept.err << swept.out;
  const auto run = run_program({"run", graph, "--out", (folder / "joined").string(), "--report",
                                (folder / "joined.json").string(), "--cache", cache, "--quiet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::map<std::string, std::string> volumes;
  int blocks = 0;
  const json report = json::parse(*read_file(folder / "joined.json"));
  for (const auto& node : report.at("nodes")) {
    const std::string name = node.at("name");
    if (node.at("outputs").contains("volume")) volumes[name] = node.at("outputs").at("volume").at("content");
    if (!name.starts_with("block[")) continue;
    ++blocks;
    EXPECT_EQ(node.at("status"), "disk") << name;
  }
  EXPECT_EQ(blocks, 8);
  EXPECT_EQ(volumes.at("joined"), volumes.at("whole"));
}

TEST_F(Slurm, AKilledTaskRunsAgain) { expect_a_killed_task_runs_again(start()); }

TEST_F(Slurm, ADeadNodeIsReplaced) {
  auto run = start();
  ASSERT_TRUE(wait_until(60, [&] { return reports() >= 1 && !cluster->tasks("n1").empty(); }));
  expect_a_dead_node_is_replaced(std::move(run));
}

TEST_F(Slurm, ATaskBeyondItsTimeLimitRunsAgain) {
  auto run = start({"--slurm", "--time=1"}, "12");
  ASSERT_TRUE(wait_until(60, [&] { return !cluster->tasks().empty(); }));
  // A stopped task does nothing until its minute is over. Then Slurm continues and terminates it.
  const pid_t task = cluster->tasks().front();
  ::kill(task, SIGSTOP);
  const auto done = run.get();
  EXPECT_NE(done.err.find("ended (TIMEOUT)"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("raise the limit with --slurm '--time=…'"), std::string::npos) << done.err;
  expect_completed(done);
}

TEST_F(Slurm, CanceledFromOutsideItStopsAndTheSameCommandCompletesIt) {
  auto run = start({}, "1");  // most tasks wait
  ASSERT_TRUE(under_way());
  const auto newest = newest_job();
  cluster->command({"scancel", "--me"});
  const auto stopped = run.get();
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_EQ(stopped.err.find("submitting it again"), std::string::npos) << stopped.err;
  EXPECT_EQ(newest_job(), newest) << "a canceled task was submitted again";
  EXPECT_NE(stopped.err.find("was canceled from outside"), std::string::npos) << stopped.err;
  const auto before = reports();
  EXPECT_LT(before, 24u);
  expect_completed(on_slurm());
}

// Slurm deletes a single task that is canceled while it waits.
TEST_F(Slurm, AWaitingTaskThatIsCanceledStaysCanceled) {
  auto run = start({"--parallel", "2"}, "2");
  ASSERT_TRUE(under_way());
  const auto newest = newest_job();
  cluster->command({"scancel", std::to_string(newest) + "_11"});
  const auto stopped = run.get();
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_NE(stopped.err.find("chunk 11 of 12 was canceled from outside"), std::string::npos) << stopped.err;
  EXPECT_EQ(newest_job(), newest) << "the canceled task was submitted again";
  EXPECT_EQ(reports(), 22u);
  expect_completed(on_slurm());
}

TEST_F(Slurm, TheControllerMayRestart) { expect_the_controller_may_restart(start()); }

TEST_F(Slurm, AKilledCoordinatorFindsItsJobsAgain) {
  auto run = start();
  ASSERT_TRUE(under_way());
  ASSERT_GT(coordinator(), 0);
  ::kill(coordinator(), SIGKILL);
  EXPECT_EQ(run.get().exit_code, 128 + SIGKILL);
  const auto before = newest_job();
  const auto done = on_slurm({}, "7");  // the queued jobs decide
  EXPECT_NE(done.err.find("already queued"), std::string::npos) << done.err;
  EXPECT_EQ(newest_job(), before) << "a job was submitted again";
  expect_completed(done);
}

TEST_F(Slurm, AnInterruptCancelsTheJobsAndTheSameCommandResumes) {
  auto run = start();
  ASSERT_TRUE(under_way());
  ::kill(coordinator(), SIGINT);
  EXPECT_EQ(run.get().exit_code, 130);
  EXPECT_TRUE(wait_until(20, [&] { return cluster->queue().empty(); }));
  expect_completed(on_slurm());
}

TEST_F(Slurm, AWorkerOfAnotherVersionIsRefused) {
  const fs::path old = write_old_program(folder / "out");
  const auto refused = on_slurm(with_profile("#SBATCH --comment=profile\nTERRAZZO=" + old.string() + "\n"));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("but the sweep was planned with 0.0.1"), std::string::npos) << refused.err;
  EXPECT_EQ(reports(), 0u);
  EXPECT_TRUE(wait_until(20, [&] { return cluster->queue().empty(); }));
  expect_completed(on_slurm());
}

TEST_F(Slurm, AChangedInputFileIsReported) {
  auto run = start();
  ASSERT_TRUE(under_way());
  fs::rename(folder / "photo.png", folder / "kept.png");
  fs::copy_file(test::source_folder() / "graphs/samples/section_labels.png", folder / "photo.png");
  const auto refused = run.get();
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("photo.png' has changed since the sweep was planned"), std::string::npos)
      << refused.err;
  EXPECT_TRUE(wait_until(20, [&] { return cluster->queue().empty(); }));
  fs::rename(folder / "kept.png", folder / "photo.png");
  expect_completed(on_slurm());
}

TEST_F(Slurm, AVanishedCacheCostsTimeOnly) {
  auto run = start();
  ASSERT_TRUE(under_way());
  fs::rename(folder / "cache", folder / "gone");
  const auto done = run.get();
  // What all points share is computed again once, and not by each worker.
  EXPECT_NE(done.err.find("has lost what all points share"), std::string::npos) << done.err;
  EXPECT_EQ(count_events(folder / "out/jobs/shared.jsonl", "finished"), 2);
  for (int i = 1; i <= 24; ++i) {
    const json nodes = json::parse(*read_file(report_of(folder / "out", i))).at("nodes");
    ASSERT_FALSE(nodes.empty()) << i;
    for (const auto& node : nodes)
      EXPECT_FALSE(node.at("name") == "shape" && node.at("status") == "computed") << i;
  }
  expect_completed(done);
}

TEST_F(Slurm, AFullDiskOnANodeMovesItsWorkToOthers) {
  expect_work_moves_from_a_full_disk(on_slurm(with_full_disk()));
}

TEST_F(Slurm, AChunkThatNeverSucceedsIsGivenUp) {
  const auto given_up = on_slurm(with_profile("[ \"$SLURM_ARRAY_TASK_ID\" = 2 ] && exit 7\n"));
  EXPECT_EQ(given_up.exit_code, 1);
  EXPECT_NE(given_up.err.find("error: chunk 2 of 8"), std::string::npos) << given_up.err;
  EXPECT_NE(given_up.err.find("(3 times in a row)"), std::string::npos) << given_up.err;
  EXPECT_NE(given_up.err.find("3 of 24 points have no result"), std::string::npos) << given_up.err;
  EXPECT_EQ(reports(), 21u);
  expect_completed(on_slurm());
}

TEST_F(Slurm, AFailingPointIsReportedAndRunsAgain) {
  // Seeds stay valid, but the photo is missing: the shared job reports it once.
  fs::remove(folder / "photo.png");
  const auto failed = on_slurm();
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_NE(failed.err.find("what all points share failed"), std::string::npos) << failed.err;
  fs::copy_file(test::source_folder() / "graphs/samples/section.png", folder / "photo.png");
  expect_completed(on_slurm());
}

}  // namespace
}  // namespace terrazzo
