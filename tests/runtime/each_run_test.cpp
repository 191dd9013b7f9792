// Repeated nodes at run time: what an edit computes again, and equal results on any number of threads.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "runtime/session.h"
#include "tests/runtime/cached_run_fixture.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::count;
using test::graph_of;
using test::paths;

std::string squares(const std::string& values) {
  return "nodes:\n"
         "  c: {type: Constant, each: {k: " +
         values +
         "}, params: {value: '${k}'}}\n"
         "  d: {type: Clamp, each: {k: " +
         values +
         "}, inputs: {in: 'c[${k}].out'}, params: {high: 50}}\n"
         "  sum: {type: Sum, inputs: {in: d.out}}\n";
}

class EachRun : public test::CachedRunTest {};

TEST_F(EachRun, AnEditRunsTheElementsThatItAffects) {
  EXPECT_EQ(count(run(graph_of(squares("1:100:1"))), Status::Computed), 201);
  EXPECT_EQ(count(run(graph_of(squares("1:100:1"))), Status::Disk), 201);
  const Graph one = graph_of(squares("1:100:1"), {{{"c[7].value", "-3"}}, {}});
  EXPECT_EQ(paths(one, run(one), Status::Computed), (Paths{"c[7]", "d[7]", "sum"}));
  const Graph more = graph_of(squares("1:103:1"));
  EXPECT_EQ(paths(more, run(more), Status::Computed),
            (Paths{"c[101]", "c[102]", "c[103]", "d[101]", "d[102]", "d[103]", "sum"}));
  const Graph fewer = graph_of(squares("2:100:2"));
  EXPECT_EQ(paths(fewer, run(fewer), Status::Computed), Paths{"sum"});
  const Graph moved = graph_of(squares("100:1:-1"));  // only the order of the list is new
  EXPECT_EQ(paths(moved, run(moved), Status::Computed), Paths{"sum"});
  const Graph clamped =
      graph_of(squares("1:100:1"), {{{"c[77].value", "78"}}, {}});  // both are clamped to 50
  EXPECT_EQ(count(run(clamped), Status::Computed), 0);
}

TEST_F(EachRun, AnElementHasTheKeyOfTheNodeWrittenByHand) {
  const Graph g = graph_of(squares("1:3:1"));
  const Graph hand = graph_of(
      "nodes:\n  x: {type: Constant, params: {value: 2}}\n  y: {type: Clamp, inputs: {in: x.out}, params: "
      "{high: 50}}\n");
  const RunResult a = run(g), b = run(hand);
  EXPECT_EQ(count(b, Status::Disk), 2);
  EXPECT_EQ(a.nodes[static_cast<std::size_t>(g.find("d[2]"))].key, b.nodes[1].key);
}

TEST_F(EachRun, EqualOnAnyNumberOfThreads) {
  std::vector<OutputRecord> sums;
  for (const int threads : {1, 2, 7}) {
    Store store(test::value_types(), "");
    FileHashes hashes("");
    Evaluator e(test::value_types(), store, hashes);
    RunOptions o;
    o.threads = threads;
    const Graph g = graph_of(squares("0.1:60:0.1"));
    const RunResult r = e.run(g, o);
    EXPECT_EQ(count(r, Status::Computed), 1201);
    sums.push_back(r.nodes.back().outputs.at("out"));
  }
  EXPECT_EQ(sums[0], sums[1]);
  EXPECT_EQ(sums[0], sums[2]);
}

TEST_F(EachRun, AnErrorNamesTheElementAndOthersRun) {
  const Graph g = graph_of(
      "nodes:\n  f: {type: Fail, each: {k: [4, 5]}, params: {level: '${k}'}}\n"
      "  c: {type: Constant, each: {k: [4, 5]}, params: {value: '${k}'}}\n"
      "  sum: {type: Sum, inputs: {in: [c.out, f.out]}}\n");
  const RunResult r = run(g);
  EXPECT_EQ(paths(g, r, Status::Computed), (Paths{"c[4]", "c[5]"}));
  EXPECT_EQ(paths(g, r, Status::Skipped), Paths{"sum"});
  EXPECT_EQ(r.nodes[static_cast<std::size_t>(g.find("f[5]"))].error->text(),
            "test.yaml:3:33: error: f[5].level: it does not work with 5 (try another)");
}

TEST_F(EachRun, ExplainsElements) {
  run(graph_of(squares("1:5:1")));
  const Graph g = graph_of(squares("1:5:1"), {{{"c[2].value", "9"}}, {}});
  Store store(test::value_types(), cache);
  FileHashes hashes(cache);
  RunOptions o;
  o.output_folder = folder / "out";
  const Plan plan = plan_run(g, o, store, hashes, History(cache));
  int cached = 0;
  for (const auto& node : plan.nodes) cached += node.step == Plan::Step::Cached;
  EXPECT_EQ(cached, 8);
  ASSERT_EQ(plan.nodes[static_cast<std::size_t>(g.find("c[2]"))].reasons.size(), 1u);
  EXPECT_NE(plan.nodes[static_cast<std::size_t>(g.find("c[2]"))].reasons[0].find("value changed: 2 → 9"),
            std::string::npos);
}

TEST_F(EachRun, SessionsEditAndReadElements) {
  Session session(test::arithmetic(), test::value_types());
  ASSERT_TRUE(
      session
          .open_text("terrazzo: 1\n" + squares("1:4:1") + "outputs: {all: d.out, total: sum.out}\n", "g.yaml")
          .empty());
  EXPECT_EQ(test::number_of(session.value("total")), 10);
  EXPECT_EQ(test::number_of(session.value("d[3].out")), 3);
  EXPECT_EQ(test::number_of(session.value("all[#1]")), 2);
  try {
    session.value("all");
    ADD_FAILURE() << "a list was read as one value";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.diagnostic().message), "'all' is a list of 4");
  }
  EXPECT_THROW(session.value("d.out"), Error);
  ASSERT_TRUE(session.set("c.value", "5").empty());
  EXPECT_EQ(test::number_of(session.value("total")), 20);
  ASSERT_TRUE(session.connect("d.in", {"c[1].out"}).empty());
  EXPECT_FALSE(session.connect("d.in", {"c.out"}).empty());
  EXPECT_EQ(count(session.evaluate({"d"})->wait(), Status::Unneeded), 4);  // sum, and c[2] to c[4]
}

}  // namespace
}  // namespace terrazzo
