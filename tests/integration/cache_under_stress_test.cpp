// The cache folder under stress: killed writers, several processes, flipped bytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/cache/cache_folder.h"
#include "runtime/cache/disk_cache.h"
#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/support/all_nodes.h"
#include "tests/support/arithmetic.h"
#include "tests/support/program.h"
#include "tests/support/report_contents.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::run_program;

class CacheUnderStress : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder / "graph.yaml") << R"(terrazzo: 1
nodes:
  shape: {type: Shape, params: {kind: rock, count: 2}}
  sizes: {type: Distribution, params: {kind: lognormal, mean: 1, sd: 0.3, min: 0.5, max: 2, volume_fraction: 0.3}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {count: 150}}
  voxels: {type: Voxelize, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {resolution: 24}}
  section: {type: Section, inputs: {particles: pack.particles, shapes: shape.shapes}}
  grids: {type: Export, inputs: {volume: voxels.volume}, params: {path: grids.vdb}}
  instances: {type: Export, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {path: pack.glb}}
)";
  }
  std::vector<std::string> arguments(const fs::path& cache, const std::string& out) {
    return {"run",   (folder / "graph.yaml").string(), "--cache", cache.string(),
            "--out", (folder / out).string(),          "--quiet"};
  }
  // Content hash of every output, by node and port.
  std::map<std::string, std::string> contents(const std::string& out) {
    return test::report_contents(folder / out / "report.json");
  }
  std::vector<fs::path> entries(const fs::path& cache) {
    std::vector<fs::path> out;
    for (const char* table : {"actions", "values"})
      for (const auto& e : fs::recursive_directory_iterator(cache / table))
        if (e.is_regular_file() && e.path().filename().string().size() == 32) out.push_back(e.path());
    std::sort(out.begin(), out.end());
    return out;
  }
  fs::path folder = test::temporary_folder();
};

TEST_F(CacheUnderStress, KilledRunsLeaveNothingDamagedAndTheResultTheSame) {
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(run_program(arguments(folder / "clean", "clean_out")).exit_code, 0);
  double whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto clean = contents("clean_out");
  ASSERT_GE(clean.size(), 5u);
  const fs::path cache = folder / "cache";
  int killed = 0;
  for (int i = 0; i < 60 && killed < 20; ++i) {
    if (i % 5 == 0) fs::remove_all(cache);  // so that early moments of a run are hit often
    const double when = whole * Random(1, 0, static_cast<std::uint64_t>(i)).uniform();
    if (run_program(arguments(cache, "out"), {.kill_after = when}).exit_code == 128 + SIGKILL)
      ++killed;
    else
      whole *= 0.9;  // the run ended first, from the cache or on a less busy machine
  }
  EXPECT_GE(killed, 10) << "the kills came too late for a meaningful test";
  if (is_cache_folder(cache)) {  // the last run may have been killed before it marked the folder
    const auto verified = run_program({"cache", "verify", "--sample", "100", "--cache", cache.string()});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  }
  ASSERT_EQ(run_program(arguments(cache, "out")).exit_code, 0);
  EXPECT_EQ(contents("out"), clean);
  // Every file under a final name is complete.
  for (const char* file : {"grids.vdb", "pack.glb"})
    EXPECT_EQ(fs::file_size(folder / "out" / file) > 0, true) << file;
}

TEST_F(CacheUnderStress, EveryFlippedByteIsFoundAndNoneServed) {
  ASSERT_EQ(run_program(arguments(folder / "cache", "out")).exit_code, 0);
  const auto clean = contents("out");
  for (int i = 0; i < 50; ++i) {
    const auto files = entries(folder / "cache");
    ASSERT_GE(files.size(), 7u);
    Random random(2, 0, static_cast<std::uint64_t>(i));
    const fs::path file =
        files[static_cast<std::size_t>(random.uniform() * static_cast<double>(files.size()))];
    auto text = *read_file(file);
    text[static_cast<std::size_t>(random.uniform() * static_cast<double>(text.size()))] ^=
        static_cast<char>(1 << static_cast<int>(random.uniform() * 8));
    std::ofstream(file, std::ios::binary) << text;
    if (i % 5 == 4) {  // a run finds the damage on reading and recomputes what was lost
      ASSERT_EQ(run_program(arguments(folder / "cache", "out")).exit_code, 0);
      EXPECT_EQ(contents("out"), clean) << file;
      run_program({"cache", "verify", "--sample", "0", "--cache", (folder / "cache").string()});
      ASSERT_EQ(run_program(arguments(folder / "cache", "out")).exit_code, 0);
    } else {
      const Verified verified =  // what `terrazzo cache verify` calls
          verify_cache(folder / "cache", test::all_nodes(), test::value_types(), 0, 1, Work());
      EXPECT_EQ(verified.damaged, std::vector<std::string>{file.string()});
      ASSERT_EQ(run_program(arguments(folder / "cache", "out")).exit_code, 0);
      EXPECT_EQ(contents("out"), clean) << file;
    }
  }
}

TEST_F(CacheUnderStress, FourProcessesOnOneFolder) {
  std::vector<std::thread> processes;
  std::vector<test::ProgramRun> runs(4);
  for (std::size_t i = 0; i < 4; ++i)
    processes.emplace_back(
        [&, i] { runs[i] = run_program(arguments(folder / "cache", "out" + std::to_string(i))); });
  for (auto& p : processes) p.join();
  for (const auto& r : runs) EXPECT_EQ(r.exit_code, 0) << r.err;
  for (int i = 1; i < 4; ++i) EXPECT_EQ(contents("out" + std::to_string(i)), contents("out0"));
  const auto verified =
      run_program({"cache", "verify", "--sample", "100", "--cache", (folder / "cache").string()});
  EXPECT_EQ(verified.exit_code, 0) << verified.out;
  // Each action key is computed at most once per process.
  for (int i = 0; i < 4; ++i) {
    std::map<std::string, int> computed;
    const json report = json::parse(*read_file(folder / ("out" + std::to_string(i)) / "report.json"));
    for (const auto& node : report.at("nodes"))
      if (node.at("status") == "computed") ++computed[node.at("key")];
    for (const auto& [key, times] : computed) EXPECT_EQ(times, 1) << key;
  }
}

// Both processes have the same process id, as in two containers that share a disk.
TEST_F(CacheUnderStress, TwoPidNamespacesOnOneFolder) {
  if (!test::has_pid_namespaces()) GTEST_SKIP() << "this system cannot create pid namespaces";
  ASSERT_EQ(run_program(arguments(folder / "clean", "clean_out")).exit_code, 0);
  const auto clean = contents("clean_out");
  const fs::path cache = folder / "cache";
  for (int round = 0; round < 3; ++round) {
    fs::remove_all(cache);
    fs::remove_all(folder / "out");
    const auto runs = test::run_twice_with_one_process_id(arguments(cache, "out"));
    for (const auto& r : runs) EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(contents("out"), clean);
    const auto verified = run_program({"cache", "verify", "--sample", "100", "--cache", cache.string()});
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
    ASSERT_EQ(run_program(arguments(cache, "out")).exit_code, 0);
    EXPECT_EQ(contents("out"), clean);
  }
}

}  // namespace
}  // namespace terrazzo
