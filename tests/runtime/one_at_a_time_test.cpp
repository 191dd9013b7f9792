// Nodes that read the values of a list one after the other.
#include <gtest/gtest.h>

#include "nodes/data/table.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::count;

class OneAtATime : public ::testing::Test {
 protected:
  // As a process of its own, which has memory for all values.
  RunResult run(const std::string& type, int values = 8) {
    const Graph g = test::graph_of("nodes:\n  big: {type: Big, each: {k: \"1:" + std::to_string(values) +
                                   ":1\"}, params: {value: '${k}'}}\n  sum: {type: " + type +
                                   ", inputs: {in: big.out}}\n");
    Store store(test::value_types(), cache);
    FileHashes hashes;
    RunResult result = Evaluator(test::value_types(), store, hashes).run(g, {});
    const NodeResult& last = result.nodes.back();
    sum = last.status == Status::Failed ? 0 : test::number_of(store.get_value(last.outputs.at("out")));
    return result;
  }
  double sum = 0;
  fs::path folder = test::temporary_folder(), cache = folder / "cache";
};

TEST_F(OneAtATime, ValuesInTheCacheAreNotInMemoryTogether) {
  EXPECT_EQ(count(run("Sum"), Status::Computed), 9);
  EXPECT_EQ(sum, 36);
  const RunResult second = run("SumInTurn");
  EXPECT_EQ(count(second, Status::Computed), 1);
  EXPECT_EQ(sum, 36);
  EXPECT_EQ(second.nodes.back().metrics.at("alive"), 1);
}

TEST_F(OneAtATime, ALostValueIsComputedAgain) {
  run("Sum");
  fs::remove_all(cache / "values");
  run("SumInTurn");
  EXPECT_EQ(sum, 36);
}

TEST_F(OneAtATime, ComputedInTheSameRunTheyAreTheSame) {
  const RunResult all = run("SumInTurn", 20);
  EXPECT_EQ(count(all, Status::Computed), 21);
  EXPECT_EQ(sum, 210);
}

TEST_F(OneAtATime, ANodeThatAsksForTheWholeListIsTold) {
  const RunResult r = run("ListInTurn", 2);
  ASSERT_EQ(r.nodes.back().status, Status::Failed);
  ASSERT_TRUE(r.nodes.back().error);
  EXPECT_EQ(r.nodes.back().error->code, "node-bug");
}

}  // namespace
}  // namespace terrazzo
