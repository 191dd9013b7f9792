// A subgraph's nodes in place of its node compute the same.
#include "runtime/clients/studio/live/expand_subgraph.h"

#include <gtest/gtest.h>

#include "graph/graph.h"
#include "runtime/files.h"
#include "runtime/session.h"
#include "tests/runtime/clients/studio/sum_of_graph.h"
#include "tests/support/all_nodes.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class ExpandSubgraph : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) { write_text_atomically(folder / name, text); }
  std::string expanded(const std::string& text, const Registry& registry = test::arithmetic()) {
    return studio::expand_subgraph(read_graph(text, file), file, "part", registry);
  }
  double sum(const std::string& text) { return test::sum_of_graph(text, file); }
  const fs::path folder = test::temporary_folder(), file = folder / "graph.yaml";
};

TEST_F(ExpandSubgraph, ComputesTheSame) {
  write(
      "part.yaml",
      "terrazzo: 1\nparameters:\n  low: {type: number, default: 1}\n  high: {type: number, default: 3}\n"
      "nodes:\n  a: {type: Constant, params: {value: 20}}\n  clamp:  # kept\n    type: Clamp\n    inputs: "
      "{in: "
      "a.out}\n    params: {low: \"${low}\", high: \"${high}\"}\n  more: {type: Add, inputs: {a: clamp.out, "
      "b: "
      "a.out}}\n  unread: {type: Constant, params: {value: 1}}\ninputs: {a: a.out}\noutputs: {out: more.out, "
      "other: unread.out}\n");
  const std::string start = "# first\nterrazzo: 1\nparameters: {top: {type: number, default: 9}}\nnodes:\n",
                    end = "  sum: {type: Add, inputs: {a: part.out, b: a.out}}\noutputs: {out: part.out}\n";
  for (const std::string inputs : {"", ", inputs: {a: a.out}"}) {
    const std::string text = start +
                             "  a: {type: Constant, params: {value: 5}}\n  part: {graph: part.yaml, params: "
                             "{high: \"${top}\"}" +
                             inputs + "}\n" + end;
    const std::string now = expanded(text);
    EXPECT_EQ(sum(now), sum(text)) << now;
    EXPECT_EQ(now.find("part.yaml"), std::string::npos) << now;
    EXPECT_EQ(now.find("unread"), std::string::npos) << now;
    EXPECT_NE(now.find("# kept"), std::string::npos) << now;
    EXPECT_NE(now.find("params: {low: 1, high: \"${top}\"}"), std::string::npos) << now;
    EXPECT_NE(now.find("outputs: {out: more.out}"), std::string::npos) << now;
    EXPECT_EQ(now.find("part_a") == std::string::npos, !inputs.empty()) << now;
  }
  EXPECT_EQ(test::code_of([&] { expanded(start + "  part: {type: Constant}\n"); }), "unknown-node");
  EXPECT_EQ(test::code_of([&] { expanded(start + "  part: {graph: gone.yaml}\n"); }), "no-file");
}

// Materials of the library, with the files that they read: the same nodes with the same inputs.
TEST_F(ExpandSubgraph, KeepsEveryKeyOfAMaterial) {
  const fs::path material = test::source_folder() / "graphs/materials/aggregate.yaml";
  const std::string text = *read_file(material);
  const auto before = read_graph(text, material);
  std::string asset;
  for (const RawNode& n : before.document.nodes)
    if (!n.graph.empty()) asset = n.name;
  const std::string now = studio::expand_subgraph(before, material, asset, test::all_nodes());
  Diagnostics found;
  const Graph old = load_graph_text(text, material, test::all_nodes(), {}, found);
  const Graph graph = load_graph_text(now, material, test::all_nodes(), {}, found);
  ASSERT_TRUE(found.empty()) << found.front().text();
  EXPECT_LE(graph.nodes.size(), old.nodes.size());
  EXPECT_GT(graph.nodes.size(), 15u);
  const auto parameters = [](const GraphNode& n) {
    std::map<std::string, std::string> out;
    for (const auto& [name, p] : n.parameters) out[name] = canonical(p.value);
    return out;
  };
  for (const GraphNode& n : graph.nodes) {
    const int same = old.find(n.path) >= 0 ? old.find(n.path) : old.find(asset + "/" + n.path);
    const int renamed = same >= 0 ? same : old.find(asset + "/" + n.path.substr(asset.size() + 1));
    ASSERT_GE(renamed, 0) << n.path;
    EXPECT_EQ(old.nodes[renamed].type, n.type);
    EXPECT_EQ(parameters(old.nodes[renamed]), parameters(n)) << n.path;
    EXPECT_EQ(old.nodes[renamed].inputs.size(), n.inputs.size()) << n.path;
  }
}

}  // namespace
}  // namespace terrazzo
