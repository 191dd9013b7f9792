// Small files that would expand to huge graphs are rejected before the graph is built.
#include <gtest/gtest.h>

#include <fstream>

#include "graph/document/raw_document.h"
#include "graph/document/subgraph_files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class GraphSize : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& nodes) {
    std::ofstream(folder / name) << "terrazzo: 1\n" << nodes;
  }
  Graph load(const std::string& name) {
    found.clear();
    return load_graph(folder / name, test::arithmetic(), {}, found);
  }
  std::string all() const {
    std::string text;
    for (const auto& d : found) text += d.text() + "\n";
    return text;
  }
  // Expects exactly one message, at this line of this file.
  void expect_only(const std::string& code, const std::string& file, int line, const std::string& part) {
    ASSERT_EQ(found.size(), 1u) << all().substr(0, 2000);
    EXPECT_EQ(found[0].code, code);
    EXPECT_EQ(fs::path(found[0].place.file).filename(), file);
    EXPECT_EQ(found[0].place.line, line);
    EXPECT_NE(found[0].message.find(part), std::string::npos) << found[0].message;
  }
  fs::path folder = test::temporary_folder();
  Diagnostics found;
};

// The name of the file at a nesting level. Each file uses the next one.
std::string name(int level) { return "f" + std::to_string(level) + ".yaml"; }

TEST_F(GraphSize, AMillionNodesInSevenFilesAreRefusedWithTheirNumber) {
  for (int level = 0; level < 6; ++level) {
    std::string nodes = "nodes:\n";
    for (int i = 0; i < 10; ++i) nodes += "  n" + std::to_string(i) + ": {graph: " + name(level + 1) + "}\n";
    write(name(level), nodes);
  }
  write(name(6), "nodes:\n  c: {type: Constant}\n");
  EXPECT_TRUE(load(name(0)).nodes.empty());
  // 10 + 100 + … + 10⁶ subgraphs and 10⁶ nodes in them.
  expect_only("too-large", name(0), 3,
              "expands to 2111110 nodes, 211111 of them in 'n0'; the limit is 100000");
}

// Each of the 50,000 would refuse its 100,000 elements, and find them out first.
TEST_F(GraphSize, RepeatedNodesInRepeatedSubgraphsStopAtTheFirstRefusal) {
  write("inner.yaml", "nodes:\n  c: {type: Constant, each: {k: 1:100000:1}}\n");
  write("outer.yaml", "nodes:\n  s: {graph: inner.yaml, each: {k: 1:50000:1}}\n");
  EXPECT_TRUE(load("outer.yaml").nodes.empty());
  expect_only("too-large", "inner.yaml", 3, "expands to 199999 nodes, 100000 of them in the 100000 elements");
  write("outer.yaml", "nodes:\n  s: {graph: inner.yaml, each: {k: 1:50000:1}}\n  other: {type: Nope}\n");
  load("outer.yaml");
  EXPECT_EQ(found.size(), 1u) << all();
}

TEST_F(GraphSize, RepeatedSubgraphsOfSubgraphsAreCounted) {
  write("c.yaml", "nodes:\n  c: {type: Constant, each: {k: 1:100:1}}\n");
  write("b.yaml", "nodes:\n  c: {graph: c.yaml, each: {k: 1:100:1}}\n");
  write("a.yaml", "nodes:\n  b: {graph: b.yaml, each: {k: 1:100:1}}\n");
  load("a.yaml");
  ASSERT_EQ(found.size(), 1u) << all();
  EXPECT_EQ(found[0].code, "too-large");
  write("a.yaml", "nodes:\n  b: {graph: b.yaml, each: {k: 1:9:1}}\n");
  EXPECT_EQ(load("a.yaml").nodes.size(), 90000u) << all();
}

// Without this limit, copies of long lists would fill the memory before the number of nodes does.
TEST_F(GraphSize, CopiesOfLongListsAreCounted) {
  std::string list = "[1";
  for (int i = 2; i <= 1000; ++i) list += ", " + std::to_string(i);
  list += "]";
  write("values.yaml",
        "nodes:\n  c: {type: Constant, each: {k: 1:60000:1}, params: {value: " + list + "}}\n");
  load("values.yaml");
  expect_only("too-large", "values.yaml", 3, "MiB of values and wires; the limit is 1024");
  write("inner.yaml", "nodes:\n  c: {type: Constant, params: {value: " + list + "}}\n");
  write("outer.yaml", "nodes:\n  s: {graph: inner.yaml, each: {k: 1:50000:1}}\n");
  load("outer.yaml");
  expect_only("too-large", "outer.yaml", 3, "MiB of values and wires");
  // Wires to lists in inputs that a subgraph lacks.
  write("none.yaml", "nodes:\n  c: {type: Constant}\n");
  write("lists.yaml",
        "nodes:\n  c: {type: Constant, each: {k: 1:10000:1}}\n"
        "  s: {graph: none.yaml, each: {k: 1:1000:1}, inputs: {in: c.out}}\n");
  load("lists.yaml");
  EXPECT_NE(all().find("the wires lead to more than 4000000 elements"), std::string::npos) << all();
}

TEST_F(GraphSize, ManyMistakesAreFoundQuickly) {
  std::string nodes = "nodes:\n";
  for (int i = 0; i < 20000; ++i)
    nodes +=
        "  n" + std::to_string(i) + ": {type: Clamp, inputs: {in: missing" + std::to_string(i) + ".out}}\n";
  write("wrong.yaml", nodes);
  load("wrong.yaml");
  EXPECT_EQ(found.size(), 20000u);
}

TEST_F(GraphSize, EmptySubgraphsCountToo) {
  for (int level = 0; level < 30; ++level)
    write(name(level),
          "nodes:\n  a: {graph: " + name(level + 1) + "}\n  b: {graph: " + name(level + 1) + "}\n");
  write(name(30), "nodes: {}\n");
  load(name(0));
  expect_only("too-large", name(0), 3, "expands to 2147483646 nodes");
}

TEST_F(GraphSize, TenThousandNodesLoad) {
  std::string inner = "nodes:\n", outer = "nodes:\n";
  for (int i = 0; i < 100; ++i) {
    inner += "  c" + std::to_string(i) + ": {type: Constant}\n";
    outer += "  s" + std::to_string(i) + ": {graph: inner.yaml}\n";
  }
  write("inner.yaml", inner);
  write("outer.yaml", outer);
  const Graph g = load("outer.yaml");
  EXPECT_EQ(all(), "");
  EXPECT_EQ(g.nodes.size(), 10000u);
}

TEST_F(GraphSize, NestingHasALimitAndWorksUpToIt) {
  for (const int levels : {kMaxNesting, kMaxNesting + 1, 100}) {
    for (int level = 0; level < levels; ++level)
      write(name(level), "nodes:\n  s: {graph: " + name(level + 1) + "}\noutputs: {out: s.out}\n");
    write(name(levels), "nodes:\n  c: {type: Constant}\noutputs: {out: c.out}\n");
    const Graph g = load(name(0));
    if (levels == kMaxNesting) {
      EXPECT_EQ(all(), "");
      ASSERT_EQ(g.outputs.size(), 1u);
      EXPECT_EQ(g.nodes.at(static_cast<std::size_t>(g.outputs[0].wire.node)).type->name, "Constant");
    } else {
      expect_only("too-large", name(0), 3, "more than 32 levels deep");
    }
  }
}

TEST_F(GraphSize, FilesThatUseEachOtherManyTimesAreToldApart) {
  // Without the check in advance, expanding this takes 12! steps.
  const int files = 12;
  for (int i = 0; i < files; ++i) {
    std::string nodes = "nodes:\n";
    for (int k = 0; k < files; ++k) nodes += "  n" + std::to_string(k) + ": {graph: " + name(k) + "}\n";
    write(name(i), nodes);
  }
  load(name(0));
  ASSERT_FALSE(found.empty());
  EXPECT_NE(all().find("'f0.yaml' contains itself"), std::string::npos) << all().substr(0, 1000);
}

TEST_F(GraphSize, AFolderThatLinksToItselfIsARecursion) {
  fs::create_directory_symlink(".", folder / "d");
  fs::create_directory_symlink(".", folder / "e");
  write("a.yaml", "nodes:\n  x: {graph: d/a.yaml}\n  y: {graph: e/a.yaml}\n");
  load("a.yaml");
  ASSERT_EQ(found.size(), 2u) << all();
  for (const auto& d : found) EXPECT_EQ(d.code, "recursion") << d.text();
}

TEST_F(GraphSize, WiresThatCircleThroughSubgraphsAreAnError) {
  write("inner.yaml",
        "nodes:\n  source: {type: Constant}\n  sum: {type: Add, inputs: {a: source.out, b: source.out}}\n"
        "inputs: {value: source.out}\noutputs: {same: source.out}\n");
  write("outer.yaml", "nodes:\n  s: {graph: inner.yaml, inputs: {value: s.same}}\n");
  load("outer.yaml");
  EXPECT_NE(all().find("back to itself"), std::string::npos) << all();
}

TEST_F(GraphSize, AChainOfFiftyThousandNodesLoads) {
  std::string nodes = "nodes:\n  n0: {type: Constant}\n";
  for (int i = 1; i < 50000; ++i) {
    const std::string before = "n" + std::to_string(i - 1) + ".out";
    nodes += "  n" + std::to_string(i) + ": {type: Add, inputs: {a: " + before + ", b: " + before + "}}\n";
  }
  // The consumer comes first, so that sorting starts at the far end of the chain.
  write("chain.yaml", "nodes:\n  first: {type: Add, inputs: {a: n49999.out, b: n0.out}}\n" + nodes.substr(7));
  const Graph g = load("chain.yaml");
  EXPECT_EQ(all(), "");
  ASSERT_EQ(g.nodes.size(), 50001u);
  EXPECT_EQ(g.nodes.back().path, "first");
}

TEST_F(GraphSize, AliasesThatMultiplyAreRefused) {
  std::string laughs = "x0: &x0 [lol, lol, lol, lol, lol, lol, lol, lol, lol, lol]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = "*x" + std::to_string(i - 1);
    laughs += "x" + std::to_string(i) + ": &x" + std::to_string(i) + " [" + before;
    for (int k = 1; k < 10; ++k) laughs += ", " + before;
    laughs += "]\n";
  }
  write("laughs.yaml", laughs + "nodes:\n  c: {type: Constant, params: {value: *x11}}\n");
  load("laughs.yaml");
  EXPECT_NE(all().find("must be a value or a list of values"), std::string::npos) << all();

  std::string list = "&long [1";
  for (int i = 1; i < 10000; ++i) list += ", 1";
  std::string nodes = "nodes:\n  n0: {type: Constant, params: {value: " + list + "]}}\n";
  for (int i = 1; i < 10000; ++i)
    nodes += "  n" + std::to_string(i) + ": {type: Constant, params: {value: *long}}\n";
  write("squared.yaml", nodes);
  load("squared.yaml");
  EXPECT_NE(all().find("more than 2000000 values, with aliases expanded"), std::string::npos)
      << all().substr(0, 1000);
}

TEST_F(GraphSize, DeepAndLongFilesAreRefused) {
  for (const std::string open : {"[", "{a: ", "- ", "? "}) {
    std::string deep;
    for (int i = 0; i < 100000; ++i) deep += open;
    write("deep.yaml",
          "nodes:\n  c: " + std::string(open == "- " || open == "? " ? "\n    " : "") + deep + "\n");
    load("deep.yaml");
    ASSERT_EQ(found.size(), 1u) << open;
    EXPECT_EQ(found[0].code, "yaml") << open;
  }
  write("many.yaml", "nodes: [" + std::string(3'000'000, ',') + "]\n");
  load("many.yaml");
  expect_only("too-large", "many.yaml", 1, "more than 2000000 values");
  load_graph("/dev/zero", test::arithmetic(), {}, found);
  EXPECT_NE(all().find("'/dev/zero': it is a device"), std::string::npos) << all();
}

}  // namespace
}  // namespace terrazzo
