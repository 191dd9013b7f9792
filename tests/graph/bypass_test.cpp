// Bypassed nodes: the graph is the one without them, and their readers read what they pass through.
#include <gtest/gtest.h>

#include <fstream>

#include "graph/document/raw_document.h"
#include "runtime/run_result.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

Diagnostics errors_of(const std::string& text) {
  Diagnostics found;
  load_graph_text("terrazzo: 1\n" + text, "test.yaml", test::arithmetic(), {}, found);
  return found;
}

std::vector<std::string> target_paths(const Graph& g, const std::vector<int>& targets) {
  std::vector<std::string> out;
  for (const int i : targets) out.push_back(g.nodes[static_cast<std::size_t>(i)].path);
  return out;
}

using BypassPaths = std::vector<std::string>;

const char* const kChain =
    "nodes:\n  a: {type: Constant, params: {value: 5}}\n"
    "  one: {type: Clamp, bypass: true, inputs: {in: a.out}, params: {low: 0, high: 3}}\n"
    "  two: {type: Clamp, bypass: true, inputs: {in: one.out}, params: {low: 0, high: 2}}\n"
    "  sum: {type: Sum, inputs: {in: [two.out, a.out]}}\noutputs: {result: two.out}\n";

TEST(Bypass, ReadersReadWhatThatNodeReads) {
  const Graph g = test::graph_of(kChain);
  EXPECT_EQ(g.paths(), (BypassPaths{"a", "sum"}));
  const auto& wires = g.nodes[1].inputs.at("in");
  ASSERT_EQ(wires.size(), 2u);
  EXPECT_EQ(wires[0].node, 0);
  EXPECT_EQ(wires[0].place.line, 6);  // where the file names it
  EXPECT_EQ(g.outputs[0].wire.node, 0);
  EXPECT_EQ(g.bypassed.at("two").at("out").node, 0);
  Store store(test::value_types(), {});
  FileHashes hashes;
  Evaluator e(test::value_types(), store, hashes);
  const RunResult r = e.run(g, {});
  EXPECT_EQ(test::number_of(e.value(g, r, g.wire_to("sum.out"))), 10);
}

TEST(Bypass, ATargetStandsForWhatItPassesThrough) {
  const Graph g = test::graph_of(kChain);
  EXPECT_EQ(g.wire_to("two").node, 0);
  EXPECT_EQ(g.wire_to("two.out").node, 0);
  EXPECT_EQ(target_paths(g, target_nodes(g, {"two"})), BypassPaths{"a"});
  EXPECT_EQ(target_paths(g, target_nodes(g, {"two.out"})), BypassPaths{"a"});
  EXPECT_EQ(test::code_of([&] { target_nodes(g, {"two.aut"}); }), "cannot-bypass");
  const Graph none = test::graph_of("nodes:\n  a: {type: Constant, bypass: true}\n  b: {type: Constant}\n");
  EXPECT_EQ(test::code_of([&] { none.wire_to("a"); }), "cannot-bypass");
  EXPECT_EQ(test::code_of([&] { target_nodes(none, {"a"}); }), "cannot-bypass");
}

TEST(Bypass, WhatOnlyABypassedNodeReadsIsATarget) {
  const Graph g = test::graph_of(
      "nodes:\n  a: {type: Constant, params: {value: 5}}\n"
      "  file: {type: Write, bypass: true, inputs: {in: a.out}, params: {path: x.txt}}\n"
      "  other: {type: Write, inputs: {in: a.out}, params: {path: x.txt}}\n"
      "  b: {type: Constant}\n  clamp: {type: Clamp, bypass: true, inputs: {in: b.out}}\n");
  EXPECT_EQ(target_paths(g, g.sinks()), (BypassPaths{"other", "b"}));
}

// A node that is not ready yet can be left out, and one that passes nothing through too if nothing reads it.
TEST(Bypass, ABypassedNodeNeedsNothing) {
  const Graph g = test::graph_of(
      "nodes:\n  clamp: {type: Clamp, bypass: true}\n  more: {type: Clamp, bypass: true, inputs: {in: "
      "clamp}}\n"
      "  size: {type: FileSize, bypass: true}\n  a: {type: Constant}\n");
  EXPECT_EQ(g.paths(), BypassPaths{"a"});
  EXPECT_TRUE(g.bypassed.at("more").empty());
}

TEST(Bypass, TheFirstInputOfTheOutputsTypePasses) {
  const Graph g = test::graph_of(
      "nodes:\n  a: {type: Constant}\n  b: {type: Constant}\n"
      "  add: {type: Add, bypass: true, inputs: {b: b.out, a: a.out}}\n"
      "  late: {type: Add, bypass: true, inputs: {b: b.out}}\n"
      "  sum: {type: Sum, bypass: true, inputs: {in: [b.out, a.out]}}\n"
      "outputs: {add: add.out, late: late.out, sum: sum.out}\n");
  EXPECT_EQ(target_paths(g, {g.outputs[0].wire.node, g.outputs[1].wire.node, g.outputs[2].wire.node}),
            (BypassPaths{"a", "b", "b"}));
}

TEST(Bypass, EveryElementOfARepeatedNodePassesItsOwnInput) {
  const Graph g = test::graph_of(
      "nodes:\n  a: {type: Constant, each: {k: [1, 2]}, params: {value: \"${k}\"}}\n"
      "  limit: {type: Clamp, bypass: true, each: {k: [1, 2]}, inputs: {in: \"a[${k}].out\"}}\n"
      "  sum: {type: Sum, inputs: {in: limit.out}}\n");
  EXPECT_EQ(g.paths(), (BypassPaths{"a[1]", "a[2]", "sum"}));
  ASSERT_EQ(g.nodes[2].inputs.at("in").size(), 2u);
  EXPECT_EQ(g.nodes[2].inputs.at("in")[1].node, 1);
  EXPECT_EQ(target_paths(g, target_nodes(g, {"limit"})), (BypassPaths{"a[1]", "a[2]"}));
  EXPECT_EQ(g.wire_to("limit[2].out").node, 1);
  EXPECT_EQ(test::code_of([&] { g.wire_to("limit.out"); }), "several-values");
}

TEST(Bypass, InASubgraphTheInputOfTheEnclosingGraphPasses) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "inner.yaml")
      << "terrazzo: 1\nnodes:\n  limit: {type: Clamp, bypass: true}\n  sum: {type: Sum, inputs: {in: "
         "limit.out}}\n"
         "inputs: {value: limit.in}\noutputs: {sum: sum.out, same: limit.out}\n";
  const auto load = [&](const std::string& more) {
    Diagnostics found;
    Graph g =
        load_graph_text("terrazzo: 1\nnodes:\n  a: {type: Constant}\n  inner: {graph: inner.yaml" + more +
                            ", inputs: {value: a.out}}\n  b: {type: Sum, inputs: {in: inner.same}}\n",
                        folder / "outer.yaml", test::arithmetic(), {}, found);
    return std::pair(std::move(g), found);
  };
  const auto [g, found] = load("");
  EXPECT_TRUE(found.empty());
  EXPECT_EQ(g.paths(), (BypassPaths{"a", "inner/sum", "b"}));
  EXPECT_EQ(g.nodes[1].inputs.at("in").front().node, 0);
  EXPECT_EQ(g.nodes[2].inputs.at("in").front().node, 0);
  EXPECT_EQ(g.wire_to("inner/limit").node, 0);
  const auto whole = load(", bypass: true").second;
  ASSERT_EQ(whole.size(), 1u);
  EXPECT_EQ(whole[0].code, "cannot-bypass");
}

TEST(Bypass, MistakesAreReported) {
  const auto found = errors_of(
      "nodes:\n  a: {type: Constant, bypass: perhaps}\n  b: {type: Constant, bypass: true}\n"
      "  sum: {type: Sum, inputs: {in: b.out}}\noutputs: {b: b.out}\n");
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].code, "bad-value");
  EXPECT_EQ(found[1].code, "cannot-bypass");
  EXPECT_EQ(found[1].place.line, 5);
  EXPECT_EQ(found[1].node, "sum");
  EXPECT_EQ(found[2].code, "cannot-bypass");
  EXPECT_EQ(found[2].place.line, 6);
  const auto cycle = errors_of(
      "nodes:\n  a: {type: Clamp, bypass: true, inputs: {in: b.out}}\n"
      "  b: {type: Clamp, bypass: true, inputs: {in: a.out}}\n");
  ASSERT_EQ(cycle.size(), 1u);
  EXPECT_EQ(cycle[0].code, "cycle");
}

}  // namespace
}  // namespace terrazzo
