// Graphs of earlier versions keep loading: parameters, words of choices, ports and types that were renamed.
#include <gtest/gtest.h>

#include "graph/graph.h"
#include "graph/node_parameters.h"
#include "graph/registry.h"

namespace terrazzo {
namespace {

void nothing(Context&) {}

void low_is_below_high(const NodeParameters& p) {
  if (p.number("low") > p.number("high"))
    throw Error("bad-range", "low is above high", "raise high").parameter("low");
}

enum class Way { Fast, Exact };

void way_is_exact(const NodeParameters& p) {
  if (p.choice<Way>("way") != Way::Exact || p.optional_integer("count") || p.seed() != 1)
    throw Error("wrong", "not as declared").parameter("way");
}

Registry registry() {
  Registry out;
  out.add(NodeType("Source", 1)
              .doc_("A type of this test")
              .output("image", "Image", "An image")
              .output_was("picture")
              .output("mask", "Image", "An image")
              .parameter(Parameter::choice("way", "fast", {"fast", "exact"})
                             .word_was("quick", "fast")
                             .word_was("slow", "exact")
                             .doc_("How"))
              .parameter(Parameter::optional_integer("size", "auto").word_was("natural", "auto").doc_("Edge"))
              .compute_(nothing));
  out.add(NodeType("Sink", 1)
              .doc_("A type of this test")
              .input("image", "Image", "An image")
              .input_was("picture")
              .output("table", "Table", "A table")
              .compute_(nothing));
  out.add(NodeType("Range", 1)
              .doc_("A type of this test")
              .output("table", "Table", "A table")
              .parameter(Parameter::number("low", 0).doc_("Least"))
              .parameter(Parameter::number("high", 1).doc_("Most"))
              .check_(low_is_below_high)
              .compute_(nothing));
  out.add(NodeType("Reads", 1)
              .doc_("A type of this test")
              .output("table", "Table", "A table")
              .parameter(Parameter::choice("way", "exact", {"fast", "exact"}).doc_("How"))
              .parameter(Parameter::optional_integer("count", "auto").doc_("Number"))
              .parameter(Parameter::seed())
              .check_(way_is_exact)
              .compute_(nothing));
  return out;
}

Graph load(const std::string& text, const Registry& types, Diagnostics& found) {
  return load_graph_text(text, "test.yaml", types, {}, found);
}

int notes(const Diagnostics& found) {
  int n = 0;
  for (const auto& d : found) n += d.severity == Severity::Note && d.code == "former-name";
  return n;
}

TEST(FormerNames, OfWordsAndPortsAreReplacedWithANote) {
  const Registry types = registry();
  Diagnostics found;
  const Graph g = load(
      "terrazzo: 1\n"
      "nodes:\n"
      "  a: {type: Source, params: {way: slow, size: natural}}\n"
      "  b: {type: Sink, inputs: {picture: a.picture}}\n"
      "inputs: {photo: b.picture}\n"
      "outputs: {first: a.picture}\n",
      types, found);
  EXPECT_FALSE(has_errors(found)) << found.front().text();
  EXPECT_EQ(notes(found), 6);
  EXPECT_EQ(std::get<std::string>(g.nodes[0].parameters.at("way").value), "exact");
  EXPECT_EQ(std::get<std::string>(g.nodes[0].parameters.at("size").value), "auto");
  ASSERT_EQ(g.nodes[1].inputs.count("image"), 1u);
  EXPECT_EQ(g.nodes[1].inputs.at("image")[0].port, "image");
  EXPECT_EQ(g.outputs.at(0).wire.port, "image");
  EXPECT_EQ(g.inputs.at(0).name, "photo");
  EXPECT_EQ(g.wire_to("a.picture").port, "image");
}

TEST(FormerNames, APresentNameIsNeverTakenForAFormerOne) {
  const Registry types = registry();
  Diagnostics found;
  load(
      "terrazzo: 1\nnodes:\n  a: {type: Source, params: {way: exact}}\n  b: {type: Sink, inputs: {image: "
      "a.mask}}\n",
      types, found);
  EXPECT_TRUE(found.empty());
  load("terrazzo: 1\nnodes:\n  a: {type: Source, params: {way: sloow}}\n", types, found);
  EXPECT_TRUE(has_errors(found));
}

TEST(ParameterCheck, RunsWhenAGraphIsLoadedAndNamesThePlace) {
  const Registry types = registry();
  Diagnostics found;
  load("terrazzo: 1\nnodes:\n  r:\n    type: Range\n    params:\n      high: 2\n      low: 3\n", types,
       found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "bad-range");
  EXPECT_EQ(found[0].node, "r");
  EXPECT_EQ(found[0].parameter, "low");
  EXPECT_EQ(found[0].place.line, 7);
  EXPECT_EQ(found[0].hint, "raise high");
}

TEST(ParameterCheck, SeesDefaultsAndIsSkippedWhileAParameterIsWrong) {
  const Registry types = registry();
  Diagnostics found;
  load("terrazzo: 1\nnodes:\n  r: {type: Range, params: {low: 0.5}}\n  s: {type: Reads}\n", types, found);
  EXPECT_TRUE(found.empty());
  load("terrazzo: 1\nnodes:\n  r: {type: Range, params: {low: 3, high: many}}\n", types, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "bad-value");
}

}  // namespace
}  // namespace terrazzo
