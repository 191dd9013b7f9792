// If a node that may fail does fail, the nodes that do not need it still run.
#include <fstream>

#include "graph/document/raw_document.h"
#include "graph/document/write_document.h"
#include "graph/document/write_graph.h"
#include "tests/runtime/cached_run_fixture.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

using test::graph_of;
using test::paths;

class MayFail : public test::CachedRunTest {
 protected:
  double number(const Graph& g, const std::string& output) {
    Store store(test::value_types(), {});
    FileHashes hashes;
    Evaluator e(test::value_types(), store, hashes);
    const RunResult r = e.run(g, {});
    return test::number_of(e.value(g, r, g.wire_to(output)));
  }
  Graph load(const std::string& text) {
    Diagnostics found;
    Graph g = load_graph_text("terrazzo: 1\n" + text, folder / "outer.yaml", test::arithmetic(), {}, found);
    EXPECT_TRUE(found.empty()) << found[0].text();
    return g;
  }
};

const std::string kGood = "nodes:\n  good: {type: Constant, params: {value: 5}}\n";

TEST_F(MayFail, AListTakesWhatIsLeft) {
  const Graph g = graph_of(kGood +
                           "  bad: {type: Fail, may_fail: true, params: {level: 7}}\n"
                           "  clamp: {type: Clamp, inputs: {in: bad.out}}\n"
                           "  sum: {type: Sum, inputs: {in: [good.out, bad.out, clamp.out]}}\n");
  const RunResult r = run(g);
  EXPECT_EQ(paths(g, r, Status::Failed), Paths{"bad"});
  EXPECT_EQ(paths(g, r, Status::Skipped), Paths{"clamp"});
  EXPECT_EQ(paths(g, r, Status::Computed), (Paths{"good", "sum"}));
  EXPECT_FALSE(r.failed());
  EXPECT_EQ(r.nodes[static_cast<std::size_t>(g.find("bad"))].error->text(),
            "test.yaml:4:53: warning: bad.level: it does not work with 7 (try another)");
  EXPECT_EQ(number(g, "sum.out"), 5);
  // The result is that of the graph without the nodes that failed.
  EXPECT_EQ(
      paths(g, run(graph_of(kGood + "  sum: {type: Sum, inputs: {in: [good.out]}}\n")), Status::Disk).size(),
      2u);
}

TEST_F(MayFail, ARequiredInputThatIsGoneSkipsTheNodeQuietly) {
  const Graph g = graph_of(kGood +
                           "  bad: {type: Fail, may_fail: true, params: {level: 7}}\n"
                           "  write: {type: Write, inputs: {in: bad.out}, params: {path: x.txt}}\n");
  const RunResult r = run(g);
  EXPECT_EQ(paths(g, r, Status::Skipped), Paths{"write"});
  EXPECT_FALSE(r.failed());
  EXPECT_FALSE(std::filesystem::exists(folder / "out" / "x.txt"));
}

TEST_F(MayFail, OtherFailuresStillFailTheRun) {
  const Graph g = graph_of(kGood +
                           "  bad: {type: Fail, may_fail: true, params: {level: 7}}\n"
                           "  worse: {type: Fail, params: {level: 8}}\n"
                           "  sum: {type: Sum, inputs: {in: [good.out, bad.out, worse.out]}}\n");
  const RunResult r = run(g);
  EXPECT_TRUE(r.failed());
  EXPECT_EQ(paths(g, r, Status::Skipped), Paths{"sum"});
}

TEST_F(MayFail, ARunWithoutAnyResultFails) {
  const Graph g = graph_of(
      "nodes:\n  bad: {type: Fail, may_fail: true, params: {level: 7}}\n"
      "  sum: {type: Sum, inputs: {in: [bad.out, bad.out]}}\n");
  const RunResult r = run(g);
  EXPECT_EQ(paths(g, r, Status::Skipped), Paths{"sum"});  // with no other input
  EXPECT_TRUE(r.failed());
  ASSERT_EQ(r.errors().size(), 1u);
  EXPECT_EQ(r.errors()[0].severity, Severity::Error);
  EXPECT_EQ(test::code_of([&] { number(g, "sum.out"); }), "no-value");
}

TEST_F(MayFail, NothingInASubgraphGoesOnWithoutAFailedNode) {
  std::ofstream(folder / "inner.yaml") << "terrazzo: 1\n" + kGood +
                                              "  bad: {type: Fail, params: {level: 7}}\n"
                                              "  sum: {type: Sum, inputs: {in: [good.out, bad.out]}}\n"
                                              "outputs: {sum: sum.out}\n";
  const Graph g = load(kGood +
                       "  part: {graph: inner.yaml, may_fail: true}\n"
                       "  sum: {type: Sum, inputs: {in: [good.out, part.sum]}}\n");
  const RunResult r = run(g);
  EXPECT_EQ(paths(g, r, Status::Skipped), Paths{"part/sum"});  // although a list is left
  EXPECT_FALSE(r.failed());
  EXPECT_EQ(number(g, "sum.out"), 5);
}

TEST_F(MayFail, TheInnermostPartThatMayFailIsLeftOut) {
  std::ofstream(folder / "inner.yaml") << "terrazzo: 1\n" + kGood +
                                              "  bad: {type: Fail, may_fail: true, params: {level: 7}}\n"
                                              "  sum: {type: Sum, inputs: {in: [good.out, bad.out]}}\n"
                                              "outputs: {sum: sum.out}\n";
  const Graph g = load(
      "nodes:\n  part: {graph: inner.yaml, may_fail: true}\n  clamp: {type: Clamp, inputs: {in: part.sum}, "
      "params: {low: 0, high: 3}}\n");
  EXPECT_EQ(paths(g, run(g), Status::Computed), (Paths{"clamp", "part/good", "part/sum"}));
}

TEST_F(MayFail, AFileRemembersOnlyWhatItCameFrom) {
  const Graph g = graph_of(kGood +
                           "  bad: {type: Fail, may_fail: true, params: {level: 7}}\n"
                           "  sum: {type: Sum, inputs: {in: [good.out, bad.out]}}\n");
  const std::vector<bool> used = used_nodes(g, run(g), g.find("sum"));
  const Graph again = graph_of(write_graph(g, used).substr(std::string("terrazzo: 1\n").size()));
  EXPECT_EQ(again.paths(), (Paths{"good", "sum"}));
  EXPECT_EQ(number(again, "sum.out"), 5);
}

TEST(MayFailDocument, IsKeptAndChecked) {
  const std::string text = kGood + "  bad: {type: Fail, may_fail: true, params: {level: 7}}\n";
  const Graph g = graph_of(text);
  EXPECT_EQ(g.nodes[1].may_fail, "bad");
  EXPECT_EQ(graph_of(write_graph(g).substr(std::string("terrazzo: 1\n").size())).nodes[1].may_fail, "bad");
  Diagnostics found;
  const RawDocument document = read_document("terrazzo: 1\n" + text, "test.yaml", found);
  EXPECT_NE(write_document(document).find("may_fail: true"), std::string::npos);
  load_graph_text("terrazzo: 1\nnodes:\n  a: {type: Constant, may_fail: perhaps}\n", "test.yaml",
                  test::arithmetic(), {}, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].text(), "test.yaml:3:23: error: may_fail of 'a' must be true or false");
}

}  // namespace
}  // namespace terrazzo
