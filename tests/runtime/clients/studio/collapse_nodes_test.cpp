// Nodes as a subgraph compute the same, also after this is taken back by expanding it.
#include "runtime/clients/studio/live/collapse_nodes.h"

#include <gtest/gtest.h>

#include "graph/graph.h"
#include "runtime/clients/studio/live/expand_subgraph.h"
#include "runtime/files.h"
#include "runtime/session.h"
#include "tests/runtime/clients/studio/sum_of_graph.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class CollapseNodes : public ::testing::Test {
 protected:
  studio::NewSubgraph collapsed(const std::string& text, const std::vector<std::string>& nodes) {
    return studio::collapse_nodes(read_graph(text, file), file, nodes, "part", "part.yaml");
  }
  double sum(const std::string& text) { return test::sum_of_graph(text, file); }
  const fs::path folder = test::temporary_folder(), file = folder / "graph.yaml";
  const std::string graph =
      "# about the whole graph\nterrazzo: 1\nname: Whole\nparameters:\n  low: {type: number, default: 1}\n  "
      "high: {type: number, default: 7}\nnodes:\n  a: {type: Constant, params: {value: 20}}\n  b: {type: "
      "Constant, params: {value: 4}}\n  clamp:  # kept\n    type: Clamp\n    inputs: {in: a.out}\n    "
      "params: "
      "{low: 0, high: \"${high}\"}\n  more: {type: Add, inputs: {a: clamp.out, b: b.out}}\n  sum: {type: "
      "Add, inputs: {a: more.out, b: clamp.out}}\noutputs: {out: more.out, first: a.out}\n";
};

TEST_F(CollapseNodes, ComputesTheSame) {
  const double expected = sum(graph);
  for (const std::vector<std::string>& nodes : {std::vector<std::string>{"clamp"},
                                                {"clamp", "more"},
                                                {"more", "clamp", "a"},
                                                {"a", "b", "more", "clamp"}}) {
    const auto made = collapsed(graph, nodes);
    write_text_atomically(folder / "part.yaml", made.subgraph);
    EXPECT_EQ(sum(made.graph), expected) << made.graph << made.subgraph;
    EXPECT_NE(made.subgraph.find("clamp:  # kept"), std::string::npos) << made.subgraph;
    EXPECT_EQ(made.subgraph.find("low: {type"), std::string::npos) << made.subgraph;
    EXPECT_EQ(made.subgraph.find("about the whole"), std::string::npos) << made.subgraph;
    EXPECT_NE(made.graph.find("params: {high: \"${high}\"}"), std::string::npos) << made.graph;
    EXPECT_EQ(made.graph.find("# about the whole"), 0u);
    const auto back = studio::expand_subgraph(read_graph(made.graph, file), file, "part", test::arithmetic());
    EXPECT_EQ(sum(back), expected) << back;
  }
}

TEST_F(CollapseNodes, NamesWhatCrosses) {
  const auto made = collapsed(graph, {"clamp", "more"});
  EXPECT_NE(made.subgraph.find("inputs: {in: clamp.in, b: more.b}"), std::string::npos) << made.subgraph;
  EXPECT_NE(made.subgraph.find("outputs: {clamp_out: clamp.out, out: more.out}"), std::string::npos)
      << made.subgraph;
  EXPECT_NE(made.graph.find("outputs: {out: part.out, first: a.out}"), std::string::npos) << made.graph;
}

TEST_F(CollapseNodes, RefusesWhatASubgraphCannotSay) {
  EXPECT_EQ(test::code_of([&] { collapsed(graph, {}); }), "unknown-node");
  EXPECT_EQ(test::code_of([&] { collapsed(graph, {"nobody"}); }), "unknown-node");
  EXPECT_EQ(test::code_of([&] { collapsed(graph + "inputs: {in: a.out}\n", {"a"}); }), "cannot-edit");
  const std::string each =
      "terrazzo: 1\nnodes:\n  a: {type: Constant, each: {k: [1, 2]}, params: {value: \"${k}\"}}\n  sum: "
      "{type: "
      "Add, inputs: {a: \"a[1].out\", b: \"a[2].out\"}}\n";
  EXPECT_EQ(test::code_of([&] { collapsed(each, {"sum"}); }), "cannot-edit");
}

}  // namespace
}  // namespace terrazzo
