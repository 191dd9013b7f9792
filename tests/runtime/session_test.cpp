#include "runtime/session.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "graph/document/raw_document.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::number_of;

const char* const graph =
    "terrazzo: 1\n"
    "nodes:\n"
    "  a: {type: Constant, params: {value: 5}}\n"
    "  b: {type: Constant, params: {value: 2}}\n"
    "  clamp: {type: Clamp, inputs: {in: a.out}, params: {low: 0, high: 3}}\n"
    "  sum: {type: Add, inputs: {a: clamp.out, b: b.out}}\n";

class SessionTest : public ::testing::Test {
 protected:
  Session session{test::arithmetic(), test::value_types()};
  void open(const std::string& text) {
    for (const auto& d : session.open_text(text, "session.yaml")) ADD_FAILURE() << d.text();
  }
};

TEST_F(SessionTest, ValuesFollowEdits) {
  open(graph);
  EXPECT_EQ(number_of(session.value("sum")), 5);
  EXPECT_TRUE(session.set("b.value", "7").empty());
  EXPECT_EQ(number_of(session.value("sum")), 10);
  EXPECT_TRUE(session.connect("sum.b", {"clamp.out"}).empty());
  EXPECT_EQ(number_of(session.value("sum")), 6);
}

TEST_F(SessionTest, AWrongEditChangesNothing) {
  open(graph);
  const auto before = session.graph();
  EXPECT_TRUE(has_errors(session.set("b.valeu", "7")));
  EXPECT_TRUE(has_errors(session.set("c.value", "7")));
  EXPECT_TRUE(has_errors(session.connect("sum.b", {})));           // a required input
  EXPECT_TRUE(has_errors(session.connect("sum.b", {"sum.out"})));  // a cycle
  EXPECT_TRUE(has_errors(session.connect("nothing.b", {"a.out"})));
  EXPECT_TRUE(has_errors(session.open_text("terrazzo: 1\nnodes: {x: {type: Nope}}\n", "x.yaml")));
  EXPECT_EQ(session.graph(), before);
  EXPECT_EQ(number_of(session.value("sum")), 5);
}

TEST_F(SessionTest, AnEditStopsWhatItMakesObsoleteAndNothingElse) {
  open(
      "terrazzo: 1\n"
      "nodes:\n"
      "  endless: {type: Endless}\n"
      "  limited: {type: Clamp, inputs: {in: endless.out}}\n"
      "  other: {type: Constant, params: {value: 4}}\n"
      "  sum: {type: Add, inputs: {a: limited.out, b: other.out}}\n");
  struct Started : Observer {
    std::atomic<bool> endless{false};
    void started(int) override { endless = true; }
  } observer;
  const auto running = session.evaluate({"limited"}, &observer);
  while (!observer.endless) std::this_thread::yield();
  EXPECT_TRUE(session.set("other.value", "5").empty());  // affects no running node
  EXPECT_FALSE(running->done());
  EXPECT_TRUE(session.connect("limited.in", {"other.out"}).empty());
  EXPECT_FALSE(running->done());  // `endless` itself did not change
  running->cancel();
  EXPECT_TRUE(running->wait().cancelled());
  EXPECT_EQ(number_of(session.value("sum")), 6);
}

TEST_F(SessionTest, AnEditOfARunningNodeStopsIt) {
  open("terrazzo: 1\nnodes:\n  e: {type: Endless}\n  c: {type: Clamp, inputs: {in: e.out}}\n");
  const auto running = session.evaluate();
  // The new graph does not contain the node.
  open("terrazzo: 1\nnodes:\n  c: {type: Constant}\n");
  EXPECT_TRUE(running->wait().cancelled());
  EXPECT_EQ(number_of(session.value("c")), 1);
}

TEST_F(SessionTest, TwoEvaluationsAtOnceComputeAKeyOnce) {
  std::string text = "terrazzo: 1\nnodes:\n  n0: {type: Big, params: {rows: 200000}}\n";
  for (int i = 1; i < 8; ++i)
    text += "  n" + std::to_string(i) + ": {type: Big, inputs: {in: n" + std::to_string(i - 1) +
            ".out}, params: {rows: 200000, value: " + std::to_string(i) + "}}\n";
  open(text);
  std::vector<std::shared_ptr<Evaluation>> all;
  for (int i = 0; i < 4; ++i) all.push_back(session.evaluate());
  int computed = 0;
  for (const auto& e : all) {
    computed += test::count(e->wait(), Status::Computed);
    EXPECT_EQ(test::count(e->wait(), Status::Computed) + test::count(e->wait(), Status::Memory), 8);
  }
  EXPECT_EQ(computed, 8);
}

TEST_F(SessionTest, AnErrorArrivesWithItsPlace) {
  open("terrazzo: 1\nnodes:\n  f: {type: Fail, params: {level: 3}}\n");
  try {
    session.value("f");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().text(),
              "session.yaml:3:35: error: f.level: it does not work with 3 (try another)");
  }
}

TEST_F(SessionTest, ADocumentIsOpenedLikeItsText) {
  Diagnostics found;
  RawDocument doc = read_document(graph, "session.yaml", found);
  ASSERT_TRUE(found.empty());
  EXPECT_TRUE(session.open_document(doc).empty());
  EXPECT_EQ(number_of(session.value("sum")), 5);
  EXPECT_TRUE(session.set("b.value", "7").empty());
  EXPECT_EQ(number_of(session.value("sum")), 10);
  doc.nodes[0].params[0].second.written.items[0] = "wrong";
  EXPECT_TRUE(has_errors(session.open_document(doc)));
  EXPECT_EQ(number_of(session.value("sum")), 10);  // the earlier document stays open
}

TEST_F(SessionTest, WaitingForAWhile) {
  open("terrazzo: 1\nnodes:\n  endless: {type: Endless}\n");
  const auto evaluation = session.evaluate();
  EXPECT_FALSE(evaluation->wait_for(std::chrono::milliseconds(20)));
  evaluation->cancel();
  evaluation->wait();
  EXPECT_TRUE(evaluation->wait_for(std::chrono::milliseconds(0)));
}

}  // namespace
}  // namespace terrazzo
