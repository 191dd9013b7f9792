// What `terrazzo explain` and the Studio say about a node that will run.
#include "runtime/report/explain.h"

#include <gtest/gtest.h>

#include "graph/graph.h"
#include "nodes/data/table.h"
#include "runtime/context.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using Lines = std::vector<std::string>;

class Explain : public ::testing::Test {
 protected:
  Explain() {
    registry.add(
        NodeType("Tint", 1)
            .doc_("test")
            .parameter(Parameter::color("color", 0, 0, 0).doc_("c"))
            .parameter(Parameter::with_keyword(ParameterKind::InputPath, "model", "built_in").doc_("m"))
            .parameter(Parameter::with_keyword(ParameterKind::Numbers, "size", "auto").doc_("s"))
            .output("out", "Table", "result")
            .compute_([](Context& c) {
              c.output("out", Table{{"value"}, {{1.0}}});
            }));
  }
  Graph graph(const std::string& parameters) const {
    Diagnostics found;
    Graph g = load_graph_text("terrazzo: 1\nnodes:\n  a: {type: Tint, params: {" + parameters + "}}\n",
                              folder / "graph.yaml", registry, {}, found);
    EXPECT_FALSE(has_errors(found)) << found.front().message;
    return g;
  }
  // Runs the first graph, and explains what the second one would run.
  Plan::Node after(const std::string& first, const std::string& second) {
    Store store(test::value_types(), folder / "cache");
    FileHashes hashes;
    const Graph before = graph(first), now = graph(second);
    History history(folder / "cache");
    history.record(before, Evaluator(test::value_types(), store, hashes).run(before, {}), hashes);
    return plan_run(now, {}, store, hashes, history).nodes[0];
  }

  Registry registry;
  const std::filesystem::path folder = test::temporary_folder();
};

TEST_F(Explain, ValuesAreShownAsPeopleWriteThem) {
  const auto node = after("color: '#000000', size: auto", "color: '#c7bda8', size: 30");
  ASSERT_EQ(node.reasons.size(), 2u);
  EXPECT_EQ(node.reasons[0].rfind("parameter color changed: #000000 → #c7bda8 (", 0), 0u) << node.reasons[0];
  EXPECT_EQ(node.reasons[1].rfind("parameter size changed: auto → 30 (", 0), 0u) << node.reasons[1];
}

TEST_F(Explain, TheNodeThatAnEditChangesHasTheTimeOfItsLastRun) {
  EXPECT_GT(after("size: 1", "size: 2").seconds, 0);
}

TEST_F(Explain, FilesAreComparedByContentAndKeywordsByName) {
  write_text_atomically(folder / "a", "1");
  write_text_atomically(folder / "b", "1");
  write_text_atomically(folder / "c", "2");
  EXPECT_EQ(after("size: 3", "size: 4").reasons.size(), 1u);  // the built-in model is the same
  const auto word = after("size: 5", "size: 5, model: a");
  ASSERT_EQ(word.reasons.size(), 1u);
  EXPECT_EQ(word.reasons[0].rfind("parameter model changed: built_in → ", 0), 0u) << word.reasons[0];
  const auto content = after("size: 6, model: a", "size: 6, model: c");
  ASSERT_EQ(content.reasons.size(), 1u);
  EXPECT_EQ(content.reasons[0].rfind("the content of model changed: ", 0), 0u) << content.reasons[0];
  EXPECT_EQ(after("size: 7, model: a", "size: 7, model: b").step, Plan::Step::Cached);
}

}  // namespace
}  // namespace terrazzo
