#include "graph/document/write_graph.h"

#include <gtest/gtest.h>

#include <fstream>

#include "runtime/evaluate.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

TEST(WriteGraph, IsTheSameGraphAgain) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "data.txt") << "123";
  std::ofstream(folder / "inner.yaml")
      << "terrazzo: 1\n"
         "parameters: {high: {type: number, default: 2}}\n"
         "nodes:\n"
         "  source: {type: Constant, params: {value: 8, note: \"a: 'b' # c\\n\\\"d\\\"\"}}\n"
         "  clamp: {type: Clamp, inputs: {in: source.out}, params: {high: \"${high}\"}}\n"
         "inputs: {source: source.out}\n"
         "outputs: {out: clamp.out}\n";
  const std::string text =
      "terrazzo: 1\nname: Outer\nnodes:\n"
      "  size: {type: FileSize, params: {path: data.txt}}\n"
      "  plain: {graph: inner.yaml}\n"
      "  fed: {graph: inner.yaml, inputs: {source: size.out}, params: {high: 0.1}}\n"
      "  all: {type: Sum, inputs: {in: [plain.out, fed.out, size.out]}}\n"
      "outputs: {result: all.out}\n";
  Diagnostics found;
  const Graph before = load_graph_text(text, folder / "outer.yaml", test::arithmetic(), {}, found);
  ASSERT_TRUE(found.empty()) << found[0].text();
  for (const auto& base : {std::filesystem::path(), folder / "deep" / "down"}) {
    const std::string written = write_graph(before, {}, base);
    const Graph after = load_graph_text(written, (base.empty() ? folder : base) / "again.yaml",
                                        test::arithmetic(), {}, found);
    ASSERT_TRUE(found.empty()) << found[0].text() << "\n" << written;
    ASSERT_EQ(after.nodes.size(), before.nodes.size());
    FileHashes hashes;
    for (const auto& node : before.nodes) {
      const int i = after.find(node.path);
      ASSERT_GE(i, 0) << node.path;
      const GraphNode& again = after.nodes[static_cast<std::size_t>(i)];
      EXPECT_EQ(action_key(again, input_files(again, hashes).hashes, {}),
                action_key(node, input_files(node, hashes).hashes, {}));
      EXPECT_EQ(again.inputs.size(), node.inputs.size());
    }
    ASSERT_EQ(after.outputs.size(), 1u);
    EXPECT_EQ(after.outputs[0].name, "result");
    if (!base.empty()) {
      EXPECT_EQ(written.find(folder.string()), std::string::npos) << written;
    }
  }
}

TEST(WriteGraph, WritesOnlyWhatIsAskedFor) {
  const Graph g = test::graph_of("nodes:\n  a: {type: Constant}\n  b: {type: Constant}\n");
  const std::string written = write_graph(g, {true, false});
  EXPECT_NE(written.find("a:"), std::string::npos);
  EXPECT_EQ(written.find("b:"), std::string::npos);
}

TEST(FormerNames, AreReadWithANote) {
  Diagnostics found;
  const Graph g = load_graph_text(
      "terrazzo: 1\nnodes:\n  a: {type: Constant}\n  b: {type: Limit, inputs: {in: a.out}, params: {minimum: "
      "0.5}}\n",
      "old.yaml", test::arithmetic(), {}, found);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].text(), "old.yaml:4:13: note: b: Limit is now called Clamp");
  EXPECT_EQ(found[1].text(), "old.yaml:4:59: note: b: 'minimum' of Clamp is now called 'low'");
  EXPECT_FALSE(has_errors(found));
  const auto& node = g.nodes[static_cast<std::size_t>(g.find("b"))];
  EXPECT_EQ(node.type->name, "Clamp");
  EXPECT_EQ(std::get<double>(node.parameters.at("low").value), 0.5);
}

TEST(Places, AMistakeInASubgraphTellsTheWholeWay) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "deep.yaml") << "terrazzo: 1\nnodes:\n  f: {type: Fail, params: {level: x}}\n";
  std::ofstream(folder / "middle.yaml") << "terrazzo: 1\nnodes:\n  deep: {graph: deep.yaml}\n";
  const std::string outer = "terrazzo: 1\nnodes:\n  one: {type: Constant}\n  use: {graph: middle.yaml}\n";
  Diagnostics found;
  load_graph_text(outer, folder / "outer.yaml", test::arithmetic(), {}, found);
  ASSERT_EQ(found.size(), 1u);
  const std::string base = folder.string();
  EXPECT_EQ(found[0].text(), base +
                                 "/deep.yaml:3:35: error: use/deep/f.level: 'x' is not a whole number\n"
                                 "  in the graph used at " +
                                 base +
                                 "/middle.yaml:3:3\n"
                                 "  in the graph used at " +
                                 base + "/outer.yaml:4:3");
  // The same for an error that only running the graph finds.
  std::ofstream(folder / "deep.yaml") << "terrazzo: 1\nnodes:\n  f: {type: Fail, params: {level: 2}}\n";
  found.clear();
  const Graph g = load_graph_text(outer, folder / "outer.yaml", test::arithmetic(), {}, found);
  ASSERT_TRUE(found.empty());
  Store store(test::value_types(), {});
  FileHashes hashes;
  const int f = g.find("use/deep/f");
  RunOptions o;
  o.targets = {f};
  const RunResult r = Evaluator(test::value_types(), store, hashes).run(g, o);
  ASSERT_TRUE(r.nodes[static_cast<std::size_t>(f)].error);
  EXPECT_EQ(r.nodes[static_cast<std::size_t>(f)].error->through.size(), 2u);
}

}  // namespace
}  // namespace terrazzo
