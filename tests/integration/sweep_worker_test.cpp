// Sweeps that workers run by hand, as any batch system would.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "runtime/cache/cache_folder.h"
#include "runtime/files.h"
#include "runtime/sweep/sweep_log.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::run_program;

class SweepWorker : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder / "graph.yaml") << R"(terrazzo: 1
nodes:
  pattern: {type: Pattern, params: {kind: wood, width: 16, height: 16}}
  grain: {type: Grain, inputs: {image: pattern.image}}
  photo: {type: LoadImage, params: {path: photo.png}}
  copy: {type: Export, inputs: {image: grain.image}, params: {path: copy.png}}
)";
    fs::copy_file(test::source_folder() / "graphs/samples/section.png", folder / "photo.png");
  }
  test::ProgramRun sweep(const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "sweep", (folder / "graph.yaml").string(), "--vary",  "grain.seed=1:5:1",
        "--out", (folder / out).string(),          "--cache", (folder / (out + "_cache")).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  std::vector<std::string> worker_arguments(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"sweep-worker", (folder / "out/sweep.json").string(), "--cache",
                                          (folder / "out_cache").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  test::ProgramRun worker(const std::vector<std::string>& more) {
    return run_program(worker_arguments(more));
  }
  json report(const std::string& out, int point) {
    const auto text = read_file(folder / out / ("point-00" + std::to_string(point)) / "report.json");
    return text ? json::parse(*text) : json();
  }
  std::map<std::string, std::string> contents(const std::string& out) {
    std::map<std::string, std::string> found;
    for (int i = 1; i <= 5; ++i)
      if (const json r = report(out, i); r.is_object())
        for (const auto& node : r.at("nodes")) {
          const std::string name = std::to_string(i) + "." + node.at("name").get<std::string>() + ".";
          for (const auto& [port, o] : node.at("outputs").items()) found[name + port] = o.at("content");
          for (const auto& file : node.at("files")) found[name + "file"] = file.at("path");
        }
    return found;
  }
  std::vector<json> events(const std::string& name) {
    return LogReader(jobs_folder(folder / "out") / (name + ".jsonl"), false).news();
  }
  // Changes the planned sweep with sed.
  void edit_plan(const std::string& expression) {
    ASSERT_EQ(test::run_command({"sed", "-i", expression, (folder / "out/sweep.json").string()}).exit_code,
              0);
  }
  fs::path folder = test::temporary_folder();
};

TEST_F(SweepWorker, WorkersInAnyOrderGiveTheResultsOfALocalRun) {
  const auto planned = sweep("out", {"--plan"});
  ASSERT_EQ(planned.exit_code, 0) << planned.err;
  EXPECT_FALSE(fs::exists(folder / "out/point-001"));
  for (const char* chunk : {"2/3", "0/3", "1/3"}) {
    const auto run = worker({"--chunk", chunk});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  ASSERT_EQ(sweep("local", {"--jobs", "2"}).exit_code, 0);
  EXPECT_EQ(contents("out").size(), 5u * 4);
  EXPECT_EQ(contents("out"), contents("local"));
  const auto gathered = sweep("out", {});
  EXPECT_EQ(gathered.exit_code, 0) << gathered.err;
  EXPECT_NE(gathered.out.find("[5/5] "), std::string::npos) << gathered.out;
  EXPECT_EQ(gathered.out.find(" 1 computed"), std::string::npos) << gathered.out;
  EXPECT_TRUE(fs::exists(folder / "out/sweep.csv"));
}

TEST_F(SweepWorker, RunsOnlyThePointsWithoutAResult) {
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  ASSERT_EQ(worker({"--chunk", "0/1"}).exit_code, 0);
  fs::remove(folder / "out/point-002/report.json");
  fs::remove(folder / "out/point-004/copy.png");  // its report is still there
  const auto before = events("chunk-0-of-1").size();
  ASSERT_EQ(worker({"--chunk", "0/1"}).exit_code, 0);
  std::vector<int> started;
  const auto all = events("chunk-0-of-1");
  for (std::size_t i = before; i < all.size(); ++i)
    if (all[i].at("event") == "started") started.push_back(all[i].at("point"));
  EXPECT_EQ(started, (std::vector<int>{2, 4}));
  EXPECT_TRUE(fs::exists(folder / "out/point-004/copy.png"));
}

TEST_F(SweepWorker, StopsIfItNeedsWhatIsSharedAndTheCacheHasLostIt) {
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  EXPECT_EQ(worker({"--chunk", "0/1", "--need-shared"}).exit_code, 1);  // it was never computed
  EXPECT_EQ(events("chunk-0-of-1").back().at("event"), "missing");
  ASSERT_EQ(worker({"--shared"}).exit_code, 0);
  EXPECT_EQ(worker({"--chunk", "0/2", "--need-shared"}).exit_code, 0);
  fs::remove_all(folder / "out_cache");
  EXPECT_EQ(worker({"--chunk", "1/2", "--need-shared"}).exit_code, 1);
  EXPECT_FALSE(report("out", 5).is_object());
  EXPECT_EQ(worker({"--chunk", "1/2"}).exit_code, 0);
}

TEST_F(SweepWorker, ComputesWhatIsSharedOnceBefore) {
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  ASSERT_EQ(worker({"--shared"}).exit_code, 0);
  EXPECT_EQ(events("shared").back().at("computed"), 2);  // pattern and photo
  ASSERT_EQ(worker({"--chunk", "0/1"}).exit_code, 0);
  for (int i = 1; i <= 5; ++i) {
    const json nodes = report("out", i).at("nodes");
    ASSERT_FALSE(nodes.empty());
    for (const auto& node : nodes)
      EXPECT_EQ(node.at("status") == "computed", node.at("name") == "grain" || node.at("name") == "copy");
  }
}

TEST_F(SweepWorker, RefusesWhatItWouldComputeDifferently) {
  const auto refused = [&](const std::string& why) {
    const auto run = worker({"--chunk", "0/2"});
    EXPECT_EQ(run.exit_code, 1) << why;
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
    EXPECT_EQ(events("chunk-0-of-2").back().at("event"), "refused") << why;
    EXPECT_FALSE(fs::exists(folder / "out/point-001/report.json")) << why;
    ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  };
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  edit_plan("s/\"program\": .*/\"program\": \"0.0.1\",/");
  refused("but the sweep was planned with 0.0.1");
  edit_plan("s/\"Grain\": .*/\"Grain\": 0,/");
  refused("but the sweep was planned with version 0");
  edit_plan("s/\"Grain\"/\"Grian\"/");
  refused("node type 'Grian' of the sweep is not available here");
  fs::copy_file(test::source_folder() / "graphs/samples/section_labels.png", folder / "photo.png",
                fs::copy_options::overwrite_existing);
  refused("photo.png' has changed since the sweep was planned");  // and is planned with the new content
  std::ofstream(folder / "graph.yaml", std::ios::app) << "# edited\n";
  refused("graph.yaml' has changed since the sweep was planned");
  const auto other = worker({"--chunk", "0/2", "--expect", "12"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("describes another sweep"), std::string::npos) << other.err;
  const auto run = worker({"--chunk", "0/2"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(SweepWorker, APointThatCannotBeWrittenStaysMissing) {
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  std::ofstream(folder / "out/point-002") << "in the way";
  const auto run = worker({"--chunk", "0/1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(events("chunk-0-of-1").back().at("event"), "stopped") << run.err;
  EXPECT_TRUE(fs::exists(folder / "out/point-001/report.json"));
  const auto status = run_program({"status", (folder / "out").string()});
  EXPECT_EQ(status.out.find("5 points: 1 done, 0 failed, 0 running, 4 waiting\n"), 0u) << status.out;
  EXPECT_NE(status.out.find("chunk-0-of-1 on "), std::string::npos) << status.out;
  fs::remove(folder / "out/point-002");
  EXPECT_EQ(worker({"--chunk", "0/1"}).exit_code, 0);
  EXPECT_EQ(contents("out").size(), 5u * 4);
}

TEST_F(SweepWorker, AFailedPointIsReportedAndRunsAgain) {
  fs::remove(folder / "photo.png");
  const auto local = sweep("out", {});
  EXPECT_EQ(local.exit_code, 1);
  const auto failed = worker({"--chunk", "0/1"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_NE(failed.err.find("point-001: error: photo: "), std::string::npos) << failed.err;
  const auto status = json::parse(run_program({"status", (folder / "out").string(), "--json"}).out);
  EXPECT_EQ(status.at("points").at("failed"), 5);
  EXPECT_EQ(status.at("failures").at(0).at("point"), "point-001");
  EXPECT_EQ(status.at("failures").at(0).at("message").get<std::string>().find("photo: "), 0u);
}

TEST_F(SweepWorker, BadCommandLinesAreExplained) {
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  for (const char* chunk : {"", "1", "2/2", "-1/2", "-2/-1", "0/0", "0/", "/2", "0/2x", "a/b"})
    EXPECT_EQ(worker({"--chunk", chunk}).exit_code, 2) << chunk;
  EXPECT_EQ(worker({"--chunk", "0/1", "--shared"}).exit_code, 2);
  EXPECT_EQ(worker({}).exit_code, 2);
  EXPECT_EQ(run_program({"sweep-worker", (folder / "none.json").string(), "--chunk", "0/1"}).exit_code, 2);
  for (const char* text : {"", "[1]", "{\"terrazzo_sweep\": 99}", "{\"terrazzo_sweep\": 1}"}) {
    std::ofstream(folder / "bad.json") << text;
    const auto run = run_program({"sweep-worker", (folder / "bad.json").string(), "--chunk", "0/1"});
    EXPECT_EQ(run.exit_code, 2) << text;
    EXPECT_NE(run.err.find("bad.json' as a sweep"), std::string::npos) << run.err;
  }
  edit_plan("s/\"parts\": .*/\"parts\": [{\"name\": \"x\", \"targets\": [\"copy\"]}],/");
  EXPECT_EQ(worker({"--chunk", "0/1"}).exit_code, 2);  // values and parts
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  EXPECT_EQ(run_program({"status", folder.string()}).exit_code, 2);
  EXPECT_EQ(sweep("out", {"--chunk-size", "3"}).exit_code, 2);
  EXPECT_EQ(sweep("out", {"--executor", "slurm", "--jobs", "2"}).exit_code, 2);
  EXPECT_EQ(run_program({"status", (folder / "out").string(), "--log", "9"}).exit_code, 2);
  EXPECT_EQ(run_program({"status", (folder / "out").string(), "--log", "2"}).exit_code, 1);
}

// Two processes with the same process id compute the same points at the same time, as on two hosts.
TEST_F(SweepWorker, TwoHostsOnOneChunkAgreeAndCountWhatBothComputed) {
  if (!test::has_pid_namespaces()) GTEST_SKIP() << "this system cannot create pid namespaces";
  ASSERT_EQ(sweep("local", {}).exit_code, 0);
  ASSERT_EQ(sweep("out", {"--plan"}).exit_code, 0);
  const auto runs = test::run_twice_with_one_process_id(worker_arguments({"--chunk", "0/1"}));
  for (const auto& r : runs) EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(contents("out"), contents("local"));
  std::size_t computed = 0, twice = 0, records = 0;
  for (const auto& event : events("chunk-0-of-1"))
    if (event.at("event") == "finished")
      computed += event.at("computed").get<std::size_t>(), twice += event.at("twice").get<std::size_t>();
  each_cache_file(folder / "out_cache", "actions", -1, [&](const CacheFile& f) { records += bool(f.name); });
  EXPECT_EQ(records, 2u + 5 * 2);
  // Two that finish within the same moment are not counted.
  EXPECT_LE(records + twice, computed);
  EXPECT_EQ(run_program({"cache", "verify", "--sample", "20", "--cache", (folder / "out_cache").string()})
                .exit_code,
            0);
}

}  // namespace
}  // namespace terrazzo
