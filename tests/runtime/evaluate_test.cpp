#include "runtime/evaluate.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "runtime/files.h"
#include "runtime/report/explain.h"
#include "tests/runtime/cached_run_fixture.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::count;
using test::graph_of;
using test::paths;

const std::string chain =
    "nodes:\n"
    "  a: {type: Constant, params: {value: 5}}\n"
    "  b: {type: Constant, params: {value: 2}}\n"
    "  clamp: {type: Clamp, inputs: {in: a.out}, params: {low: 0, high: 3}}\n"
    "  sum: {type: Add, inputs: {a: clamp.out, b: b.out}}\n";

class Evaluate : public test::CachedRunTest {
 protected:
  Plan plan(const Graph& g) {
    Store store(test::value_types(), cache);
    FileHashes hashes(cache);
    RunOptions o;
    o.output_folder = folder / "out";
    return plan_run(g, o, store, hashes, History(cache));
  }
};

TEST_F(Evaluate, RunsOnceThenComesFromTheDisk) {
  const Graph g = graph_of(chain);
  const RunResult first = run(g), second = run(g);
  EXPECT_EQ(count(first, Status::Computed), 4);
  EXPECT_EQ(count(second, Status::Disk), 4);
  for (std::size_t i = 0; i < g.nodes.size(); ++i) EXPECT_EQ(first.nodes[i].outputs, second.nodes[i].outputs);
}

TEST_F(Evaluate, AnEditRunsExactlyWhatItTouches) {
  run(graph_of(chain));
  const Graph g = graph_of(chain, {{{"b.value", "9"}}, {}});
  EXPECT_EQ(paths(g, run(g), Status::Computed), (Paths{"b", "sum"}));
}

TEST_F(Evaluate, AnUnchangedResultStopsTheChange) {
  run(graph_of(chain));
  const Graph g = graph_of(chain, {{{"a.value", "6"}}, {}});  // still clamped to 3
  EXPECT_EQ(paths(g, run(g), Status::Computed), (Paths{"a", "clamp"}));
}

TEST_F(Evaluate, NamesDefaultsAndLayoutAreNotInTheKey) {
  run(graph_of("nodes:\n  a: {type: Constant, params: {value: 1}}\n"));
  const Graph g =
      graph_of("nodes:\n  # another name, the default not written\n  other:\n    type: Constant\n");
  EXPECT_EQ(count(run(g), Status::Disk), 1);
}

TEST_F(Evaluate, EqualNodesOfOneGraphAreComputedOnce) {
  const Graph g = graph_of(
      "nodes:\n  a: {type: Constant}\n  b: {type: Constant}\n  c: {type: Sum, inputs: {in: [a.out, b.out, "
      "a.out]}}\n");
  const RunResult r = run(g);
  EXPECT_EQ(count(r, Status::Computed), 2);
  EXPECT_EQ(count(r, Status::Memory), 1);
}

TEST_F(Evaluate, FilesAreInputsByContent) {
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
  };
  write("a.txt", "123");
  const auto graph = [&](const std::string& name) {
    return graph_of("nodes:\n  f: {type: FileSize, params: {path: '" + (folder / name).string() + "'}}\n");
  };
  EXPECT_EQ(count(run(graph("a.txt")), Status::Computed), 1);
  write("b.txt", "123");
  EXPECT_EQ(count(run(graph("b.txt")), Status::Disk), 1);  // different name, same content
  write("a.txt", "124");
  EXPECT_EQ(count(run(graph("a.txt")), Status::Computed), 1);  // same name and size, different content
  const RunResult gone = run(graph("c.txt"));
  ASSERT_EQ(count(gone, Status::Failed), 1);
  EXPECT_EQ(gone.nodes[0].error->code, "no-file");
  EXPECT_EQ(gone.nodes[0].error->parameter, "path");
  EXPECT_EQ(gone.nodes[0].error->place.line, 3);
}

TEST_F(Evaluate, WrittenFilesAreCheckedNotBelieved) {
  const Graph g = graph_of(
      "nodes:\n  a: {type: Constant}\n  w: {type: Write, inputs: {in: a.out}, params: {path: sub/x.txt}}\n");
  const auto file = folder / "out" / "sub" / "x.txt";
  EXPECT_EQ(count(run(g), Status::Computed), 2);
  EXPECT_EQ(count(run(g), Status::Disk), 2);
  std::ofstream(file) << "tampered";
  EXPECT_EQ(paths(g, run(g), Status::Computed), (Paths{"w"}));
  std::filesystem::remove(file);
  EXPECT_EQ(paths(g, run(g), Status::Computed), (Paths{"w"}));
  std::string text;
  std::ifstream(file) >> text;
  EXPECT_EQ(text, "1");
}

TEST_F(Evaluate, AFailureSparesIndependentBranches) {
  const Graph g = graph_of(
      "nodes:\n"
      "  bad: {type: Fail, params: {level: 7}}\n"
      "  after: {type: Clamp, inputs: {in: bad.out}}\n"
      "  good: {type: Constant}\n");
  const RunResult r = run(g);
  EXPECT_EQ(paths(g, r, Status::Failed), (Paths{"bad"}));
  EXPECT_EQ(paths(g, r, Status::Skipped), (Paths{"after"}));
  EXPECT_EQ(paths(g, r, Status::Computed), (Paths{"good"}));
  const Diagnostic& d = *r.nodes[static_cast<std::size_t>(g.find("bad"))].error;
  EXPECT_EQ(d.text(), "test.yaml:3:37: error: bad.level: it does not work with 7 (try another)");
}

TEST_F(Evaluate, CancelStopsAndKeepsWhatIsDone) {
  const Graph g = graph_of(
      "nodes:\n  a: {type: Constant}\n  e: {type: Endless}\n  f: {type: Clamp, inputs: {in: e.out}}\n");
  std::atomic<bool> cancel{false};
  struct Canceller : Observer {
    std::atomic<bool>* flag;
    void started(int) override { ++begun; }
    void finished(int, const NodeResult& r) override {
      if (r.status == Status::Computed) *flag = true;
    }
    int begun = 0;
  } observer;
  observer.flag = &cancel;
  RunOptions o;
  o.cancel = &cancel;
  o.observer = &observer;
  o.threads = 2;
  const RunResult r = run(g, o);
  EXPECT_TRUE(r.cancelled());
  EXPECT_EQ(paths(g, r, Status::Cancelled), (Paths{"e", "f"}));
  EXPECT_EQ(paths(g,
                  run(g,
                      [] {
                        RunOptions p;
                        p.targets = {0};
                        return p;
                      }()),
                  Status::Disk),
            (Paths{"a"}));
}

TEST_F(Evaluate, AnObserverThatThrowsCostsNoResult) {
  const Graph g = graph_of("nodes:\n  a: {type: Constant}\n  b: {type: Clamp, inputs: {in: a.out}}\n");
  struct Thrower : Observer {
    void started(int) override { throw std::runtime_error("no terminal"); }
    void finished(int, const NodeResult&) override { throw std::runtime_error("no terminal either"); }
  } observer;
  RunOptions o;
  o.observer = &observer;
  const RunResult r = run(g, o);
  EXPECT_EQ(paths(g, r, Status::Computed), (Paths{"a", "b"}));
  EXPECT_EQ(r.trouble, "the progress display stopped: no terminal");
}

TEST_F(Evaluate, PreviewsReachOnlyObserversThatWantThemAndAreNoResults) {
  const Graph g = graph_of("nodes:\n  a: {type: Sketch, params: {value: 8}}\n");
  struct Watcher : Observer {
    bool wants_previews(int) override { return wants; }
    void preview(int node, const std::string& port, const Value& v) override {
      EXPECT_EQ(node, 0);
      EXPECT_EQ(port, "out");
      seen.push_back(test::number_of(v));
    }
    bool wants = false;
    std::vector<double> seen;
  } observer;
  RunOptions o;
  o.observer = &observer;
  const RunResult plain = run(g, o);
  EXPECT_TRUE(observer.seen.empty());
  std::filesystem::remove_all(cache);
  observer.wants = true;
  const RunResult watched = run(g, o);
  EXPECT_EQ(observer.seen, std::vector<double>{4});
  EXPECT_EQ(watched.nodes[0].outputs, plain.nodes[0].outputs);
  EXPECT_EQ(watched.nodes[0].key, plain.nodes[0].key);
  observer.seen.clear();
  EXPECT_EQ(count(run(g, o), Status::Disk), 1);
  EXPECT_TRUE(observer.seen.empty());
}

TEST_F(Evaluate, DamagedCacheFilesAreMissesNeverResults) {
  const Graph g = graph_of(chain);
  const RunResult clean = run(g);
  std::vector<std::filesystem::path> files;
  for (const auto& e : std::filesystem::recursive_directory_iterator(cache))
    if (e.is_regular_file()) files.push_back(e.path());
  ASSERT_GE(files.size(), 8u);
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < files.size(); ++i) {
    auto text = read_file(files[i]);
    if (!text || text->empty()) continue;
    (*text)[(i * 7919) % text->size()] ^= 1;
    std::ofstream(files[i], std::ios::binary) << *text;
    std::ofstream(files[i].parent_path() / "foreign.tmp") << "not ours";
    const RunResult r = run(g);
    EXPECT_FALSE(r.failed());
    for (std::size_t k = 0; k < g.nodes.size(); ++k) EXPECT_EQ(r.nodes[k].outputs, clean.nodes[k].outputs);
  }
}

TEST_F(Evaluate, ALostValueIsComputedAgain) {
  run(graph_of(chain));
  std::filesystem::remove_all(cache / "values");
  const Graph g = graph_of(chain, {{{"b.value", "9"}}, {}});
  Store store(test::value_types(), cache);
  FileHashes hashes;
  Evaluator e(test::value_types(), store, hashes);
  const RunResult r = e.run(g, {});
  EXPECT_FALSE(r.failed());
  EXPECT_EQ(test::number_of(e.value(g, r, g.wire_to("sum.out"))), 12);
}

TEST_F(Evaluate, AnUnwritableCacheCostsNoResult) {
  std::ofstream(folder / "file") << "in the way";
  cache = folder / "file" / "cache";
  const Graph g = graph_of(chain);
  Store store(test::value_types(), cache);
  FileHashes hashes;
  Evaluator e(test::value_types(), store, hashes);
  const RunResult r = e.run(g, {});
  EXPECT_EQ(count(r, Status::Computed), 4);
  EXPECT_FALSE(store.trouble().empty());
}

TEST_F(Evaluate, ExplainNamesTheCause) {
  EXPECT_EQ(plan(graph_of(chain)).nodes[0].reasons, (Paths{"never computed here"}));
  run(graph_of(chain));
  const Graph g = graph_of(chain, {{{"b.value", "9"}}, {}});
  const Plan p = plan(g);
  const auto& b = p.nodes[static_cast<std::size_t>(g.find("b"))];
  EXPECT_EQ(b.step, Plan::Step::Compute);
  EXPECT_EQ(b.reasons, (Paths{"parameter value changed: 2 → 9 (command line (--set b.value))"}));
  const auto& sum = p.nodes[static_cast<std::size_t>(g.find("sum"))];
  EXPECT_EQ(sum.step, Plan::Step::Perhaps);
  EXPECT_EQ(sum.reasons, (Paths{"downstream of b"}));
  EXPECT_EQ(p.nodes[static_cast<std::size_t>(g.find("clamp"))].step, Plan::Step::Cached);
}

TEST_F(Evaluate, ManyRandomEditsAgreeWithACleanRun) {
  // Incremental results equal those of a clean run, and a second run computes nothing.
  std::uint64_t seed = 1;
  for (int edit = 0; edit < 60; ++edit) {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    const std::string a = std::to_string((seed >> 33) % 7), high = std::to_string((seed >> 40) % 5);
    const Graph g = graph_of(chain, {{{"a.value", a}, {"clamp.high", high}}, {}});
    const RunResult incremental = run(g);
    Store fresh(test::value_types(), {});
    FileHashes hashes;
    const RunResult clean = Evaluator(test::value_types(), fresh, hashes).run(g, {});
    for (std::size_t i = 0; i < g.nodes.size(); ++i)
      EXPECT_EQ(incremental.nodes[i].outputs, clean.nodes[i].outputs);
    EXPECT_EQ(count(run(g), Status::Computed), 0);
  }
}

}  // namespace
}  // namespace terrazzo
