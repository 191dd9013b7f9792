// Repeated nodes: what `each` expands to, and its mistakes with their places.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "graph/describe.h"
#include "graph/document/edit_document.h"
#include "graph/document/write_document.h"
#include "graph/document/write_graph.h"
#include "graph/text/element_name.h"
#include "graph/value_range.h"
#include "runtime/random.h"
#include "runtime/report/recipe.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

using test::graph_of;
using Names = std::vector<std::string>;

// The one message of a graph, as "line:column code node: message (hint)".
std::string only_message(const std::string& nodes, const std::string& before = "") {
  Diagnostics found;
  load_graph_text("terrazzo: 1\n" + before + "nodes:\n" + nodes, "g.yaml", test::arithmetic(), {}, found);
  std::string all;
  for (const auto& d : found)
    all += std::to_string(d.place.line) + ":" + std::to_string(d.place.column) + " " + d.code + " " + d.node +
           ": " + d.message + (d.hint.empty() ? "" : " (" + d.hint + ")") + "\n";
  return all;
}

double value_of(const Graph& g, const std::string& path) {
  return std::get<double>(g.nodes.at(static_cast<std::size_t>(g.find(path))).parameters.at("value").value);
}

Names sources(const Graph& g, const std::string& path, const std::string& port) {
  Names out;
  for (const auto& w : g.nodes.at(static_cast<std::size_t>(g.find(path))).inputs.at(port))
    out.push_back(g.nodes[static_cast<std::size_t>(w.node)].path + "." + w.port);
  return out;
}

TEST(Each, RepeatsANodeInOrder) {
  const Graph g = graph_of(
      "nodes:\n"
      "  c: {type: Constant, each: {k: 3:1:-1}, params: {value: '${k}', note: 'is ${k}'}}\n"
      "  sum: {type: Sum, inputs: {in: c.out}}\n");
  EXPECT_EQ(g.paths(), (Names{"c[3]", "c[2]", "c[1]", "sum"}));
  EXPECT_EQ(value_of(g, "c[2]"), 2);
  EXPECT_EQ(std::get<std::string>(g.nodes[1].parameters.at("note").value), "is 2");
  EXPECT_EQ(sources(g, "sum", "in"), (Names{"c[3].out", "c[2].out", "c[1].out"}));
}

TEST(Each, SeveralNamesGiveAllCombinationsTheLastFastest) {
  const Graph g = graph_of(
      "nodes:\n"
      "  low: {type: Constant}\n"
      "  high: {type: Constant, params: {value: 5}}\n"
      "  c: {type: Clamp, each: {of: [low, high], to: [0.5, 2]}, inputs: {in: '${of}.out'}, params: {high: "
      "'${to}'}}\n"
      "  one: {type: Add, inputs: {a: 'c[low,0.5]', b: 'c[high,2].out'}}\n"
      "  again: {type: Clamp, each: {x: [low, high]}, inputs: {in: 'c[${x},2].out'}}\n");
  EXPECT_EQ(g.paths(), (Names{"low", "high", "c[low,0.5]", "c[low,2]", "c[high,0.5]", "c[high,2]", "one",
                              "again[low]", "again[high]"}));
  EXPECT_EQ(sources(g, "c[high,0.5]", "in"), Names{"high.out"});
  EXPECT_EQ(sources(g, "one", "a"), Names{"c[low,0.5].out"});
  EXPECT_EQ(sources(g, "again[high]", "in"), Names{"c[high,2].out"});
}

TEST(Each, ValuesComeFromParametersOfTheGraph) {
  const std::string text =
      "parameters: {last: {type: int, default: 2}, all: {type: numbers, default: [7, 8]}}\n"
      "nodes:\n"
      "  a: {type: Constant, each: {k: '0:${last}:1'}, params: {value: '${k}'}}\n"
      "  b: {type: Constant, each: {k: '${all}'}, params: {value: '${k}'}}\n"
      "  c: {type: Constant, each: {k: ['${last}', 9]}, params: {value: '${k}'}}\n";
  EXPECT_EQ(graph_of(text).paths(), (Names{"a[0]", "a[1]", "a[2]", "b[7]", "b[8]", "c[2]", "c[9]"}));
  EXPECT_EQ(graph_of(text, {{}, {{"last", "0"}, {"all", "[1]"}}}).paths(),
            (Names{"a[0]", "b[1]", "c[0]", "c[9]"}));
}

TEST(Each, OtherValuesThanWordsAreNumberedInNames) {
  const Graph g = graph_of(
      "nodes:\n  f: {type: Constant, each: {note: [a/b.png, plain, 'x, y']}, params: {note: '${note}'}}\n");
  EXPECT_EQ(g.paths(), (Names{"f[#0]", "f[plain]", "f[#2]"}));
  EXPECT_EQ(std::get<std::string>(g.nodes[2].parameters.at("note").value), "x, y");
}

TEST(Each, PathsInValuesAreRelativeToWhereTheyWereWritten) {
  const fs::path folder = test::temporary_folder();
  std::ofstream(folder / "a.txt") << "a";
  std::ofstream(folder / "g.yaml")
      << "terrazzo: 1\nparameters: {files: {type: texts, default: [a.txt]}}\n"
         "nodes:\n  f: {type: FileSize, each: {file: '${files}'}, params: {path: '${file}'}}\n";
  const auto path = [&](const Overrides& o) {
    Diagnostics found;
    const Graph g = load_graph(folder / "g.yaml", test::arithmetic(), o, found);
    EXPECT_TRUE(found.empty());
    return std::get<std::string>(g.nodes.at(0).parameters.at("path").value);
  };
  EXPECT_EQ(path({}), (folder / "a.txt").string());
  EXPECT_EQ(path({{}, {{"files", "[a.txt]"}}}), (fs::current_path() / "a.txt").string());
}

class EachSubgraph : public ::testing::Test {
 protected:
  EachSubgraph() {
    std::ofstream(folder / "part.yaml")
        << "terrazzo: 1\nparameters: {v: {type: number, default: 1}}\n"
           "nodes:\n  source: {type: Constant, params: {value: '${v}'}}\n"
           "  steps: {type: Clamp, each: {high: [1, 2]}, inputs: {in: source.out}, params: {high: "
           "'${high}'}}\n"
           "  sum: {type: Sum, inputs: {in: steps.out}}\n"
           "inputs: {in: source.out}\noutputs: {all: steps.out, sum: sum.out}\n";
  }
  Graph load(const std::string& nodes, Overrides o = {}) {
    Diagnostics found;
    Graph g = load_graph_text("terrazzo: 1\n" + nodes, folder / "g.yaml", test::arithmetic(), o, found);
    for (const auto& d : found) messages += d.text() + "\n";
    return g;
  }
  fs::path folder = test::temporary_folder();
  std::string messages;
};

TEST_F(EachSubgraph, IsRepeatedWithItsOwnLists) {
  const Graph g = load(
      "nodes:\n"
      "  p: {graph: part.yaml, each: {k: [3, 4]}, params: {v: '${k}'}}\n"
      "  all: {type: Sum, inputs: {in: [p.sum, p.all]}}\n"
      "  x: {type: Constant}\n"
      "  q: {graph: part.yaml, each: {k: [x]}, inputs: {in: '${k}.out'}}\n"
      "outputs: {lists: p.all, one: 'p[3].sum'}\n");
  EXPECT_EQ(messages, "");
  EXPECT_EQ(value_of(g, "p[4]/source"), 4);
  EXPECT_EQ(sources(g, "all", "in"), (Names{"p[3]/sum.out", "p[4]/sum.out", "p[3]/steps[1].out",
                                            "p[3]/steps[2].out", "p[4]/steps[1].out", "p[4]/steps[2].out"}));
  EXPECT_EQ(sources(g, "q[x]/steps[2]", "in"), Names{"x.out"});
  Names outputs;
  for (const auto& o : g.outputs) outputs.push_back(o.name);
  EXPECT_EQ(outputs, (Names{"lists[#0]", "lists[#1]", "lists[#2]", "lists[#3]", "one"}));
  const NodeType type = describe_graph(g);
  ASSERT_EQ(type.outputs.size(), 2u);
  EXPECT_TRUE(type.outputs[0].name == "lists" && type.outputs[0].many && !type.outputs[1].many);
  EXPECT_EQ(target_nodes(g, {"lists"}).size(), 4u);
  EXPECT_EQ(target_nodes(g, {"p/steps"}).size(), 4u);
  EXPECT_EQ(target_nodes(g, {"p/sum.out"}).size(), 2u);
  EXPECT_THROW(target_nodes(g, {"p/sum.aut"}), Error);
  EXPECT_THROW(target_nodes(g, {"p"}), Error);
}

TEST_F(EachSubgraph, OverridesReachOneElementOrAll) {
  const std::string text = "nodes:\n  p: {graph: part.yaml, each: {k: [3, 4]}, params: {v: '${k}'}}\n";
  const auto values = [&](const Overrides& o) {
    const Graph g = load(text, o);
    EXPECT_EQ(messages, "");
    return std::pair(value_of(g, "p[3]/source"), value_of(g, "p[4]/source"));
  };
  EXPECT_EQ(values({{{"p.v", "9"}}, {}}), std::pair(9.0, 9.0));
  EXPECT_EQ(values({{{"p[4].v", "9"}}, {}}), std::pair(3.0, 9.0));
  EXPECT_EQ(values({{{"p/source.value", "8"}}, {}}), std::pair(8.0, 8.0));
  EXPECT_EQ(values({{{"p[3]/source.value", "8"}}, {}}), std::pair(8.0, 4.0));
  const Graph g = load(text, {{}, {}, {{"p[3]/steps.in", {"p[3]/sum.out"}}}});
  EXPECT_NE(messages.find("cycle"), std::string::npos) << messages;
}

TEST_F(EachSubgraph, MayNotContainItself) {
  std::ofstream(folder / "self.yaml") << "terrazzo: 1\nnodes:\n  s: {graph: self.yaml, each: {k: [1, 2]}}\n";
  Diagnostics found;
  load_graph(folder / "self.yaml", test::arithmetic(), {}, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "recursion");
}

TEST(Each, MistakesHaveTheirPlaces) {
  EXPECT_EQ(only_message("  c: {type: Constant, each: {k: [1, abc, 2]}, params: {value: '${k}'}}\n"),
            "3:37 bad-value c[abc]: 'abc' is not a number\n");
  EXPECT_EQ(only_message("  c: {type: Constant, each: {k: []}}\n"),
            "3:33 bad-value c: the values of 'k' are an empty list\n");
  EXPECT_EQ(only_message("  c: {type: Constant, each: {k: [1, 2, 1]}}\n"),
            "3:40 duplicate-key c: the values of 'k' contain '1' twice\n");
  EXPECT_EQ(only_message("  c: {type: Constant, each: {k: '1:9:-1'}}\n"),
            "3:33 bad-range c: the values of 'k': the step must be nonzero and lead from LO to HI (write "
            "LO:HI:STEP)\n");
  EXPECT_EQ(
      only_message("  c: {type: Constant, each: {}}\n"),
      "3:23 bad-value : each of 'c' is empty (write each: {NAME: [VALUE, …]} or each: {NAME: LO:HI:STEP})\n");
  EXPECT_EQ(only_message("  c: {type: Constant, each: {'a b': [1]}}\n"),
            "3:37 bad-name c: 'a b' is not a valid name for values (use letters, digits and _)\n");
  EXPECT_EQ(
      only_message("  c: {type: Constant, each: {v: [1]}}\n", "parameters: {v: {type: int, default: 1}}\n"),
      "4:33 duplicate-key c: 'v' is also a parameter of the graph (choose another name)\n");
  EXPECT_EQ(only_message("  c: {type: Constant, each: {k: [1]}}\n  'c[1]': {type: Constant}\n"),
            "4:3 duplicate-key c: there is a node 'c[1]' besides the elements of 'c'\n");
  EXPECT_EQ(
      only_message("  c: {type: Constant, each: {k: [1, 2]}}\n  d: {type: Clamp, inputs: {in: c.out}}\n"),
      "4:33 too-many-wires d: input 'in' accepts one wire, but c.out is a list of 2 (name one element in "
      "brackets, or repeat this node too)\n");
  EXPECT_EQ(only_message(
                "  c: {type: Constant, each: {k: [1, 2]}}\n  d: {type: Clamp, inputs: {in: 'c[3].out'}}\n"),
            "4:33 unknown-node : 'c' has no element 'c[3]'; did you mean 'c[1]'? (its 2 elements are c[1] to "
            "c[2])\n");
  EXPECT_EQ(only_message(
                "  d: {type: Clamp, each: {k: [1, 2]}, inputs: {in: 'c${x}.out'}}\n  c: {type: Constant}\n"),
            "3:52 unknown-parameter : 'd' has no values 'x' (wires may contain k)\n");
}

TEST(Each, OneMistakeInEveryElementIsReportedOnce) {
  EXPECT_EQ(only_message("  c: {type: Constant, each: {k: 1:50:1}, params: {valeu: 1}}\n"),
            "3:58 unknown-parameter c[1]: Constant has no parameter 'valeu'; did you mean 'value'?\n");
  const std::string many =
      only_message("  c: {type: Constant, each: {k: 1001:1050:1}, params: {value: '${k}'}}\n");
  EXPECT_EQ(std::count(many.begin(), many.end(), '\n'), 5) << many;
  EXPECT_NE(many.find("(45 more elements have such an error)"), std::string::npos) << many;
}

TEST(Each, SizesAreCheckedBeforeAnythingIsBuilt) {
  EXPECT_EQ(
      only_message("  c: {type: Constant, each: {k: 1:1e9:1}}\n"),
      "3:33 too-large c: the values of 'k': the range has more than 100000 numbers (write LO:HI:STEP)\n");
  EXPECT_EQ(only_message("  c: {type: Constant, each: {a: 1:1000:1, b: 1:101:1}}\n"),
            "3:46 too-large c: 'c' has more than 100000 elements\n");
  EXPECT_EQ(
      only_message(
          "  c: {type: Constant, each: {a: 1:60000:1}}\n  d: {type: Constant, each: {a: 1:60000:1}}\n"),
      "4:33 too-large d: the graph expands to 120000 nodes, 60000 of them in the 60000 elements of 'd'; the "
      "limit is 100000 (use fewer values, or split the graph into several)\n");
  EXPECT_EQ(
      only_message("  c: {type: Constant, each: {a: 1:2000:1}}\n  d: {type: Sum, each: {a: 1:2000:1}, "
                   "inputs: {in: c.out}}\n"),
      "4:52 too-large : the graph expands to more than 2000000 wires (connect lists to fewer elements)\n");
}

TEST(Each, AHundredThousandElementsLoad) {
  const Graph g = graph_of(
      "nodes:\n  c: {type: Constant, each: {k: 1:99999:1}}\n  sum: {type: Sum, inputs: {in: c.out}}\n");
  EXPECT_EQ(g.nodes.size(), 100000u);
  EXPECT_EQ(g.nodes.back().inputs.at("in").size(), 99999u);
}

TEST(Each, DrawingsShowOneNodeWithItsNumber) {
  const Graph g = graph_of(
      "nodes:\n  c: {type: Constant, each: {k: 1:500:1}}\n  sum: {type: Sum, inputs: {in: c.out}}\n");
  for (const std::string& text : {draw_dot(g), draw_mermaid(g), draw_svg(g)}) {
    EXPECT_NE(text.find("c × 500"), std::string::npos);
    EXPECT_LT(text.size(), 3000u);
  }
}

TEST(Each, TheExpandedGraphIsAGraph) {
  const Graph g = graph_of(
      "nodes:\n"
      "  c: {type: Constant, each: {k: [0.5, 2], n: [x, 'a b']}, params: {value: '${k}', note: '${n}'}}\n"
      "  sum: {type: Sum, inputs: {in: c.out}}\noutputs: {all: c.out}\n");
  Diagnostics found;
  const Graph again = load_graph_text(write_graph(g, {}), "again.yaml", test::arithmetic(), {}, found);
  ASSERT_TRUE(found.empty()) << found[0].text() << write_graph(g, {});
  ASSERT_EQ(again.paths(), g.paths());
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    EXPECT_EQ(recipe(again, again.nodes[i]), recipe(g, g.nodes[i]));
  EXPECT_EQ(again.outputs.size(), 4u);
}

TEST(Each, DocumentsKeepIt) {
  const std::string text =
      "terrazzo: 1\nnodes:\n"
      "  c:  # constants\n    type: Constant\n    each: {k: \"1:3:1\", of: [a, b]}\n    params: {value: "
      "\"${k}\"}\n"
      "  d: {type: Clamp, inputs: {in: \"c[1,a].out\"}}\n";
  Diagnostics found;
  RawDocument doc = read_document(text, "g.yaml", found);
  ASSERT_TRUE(found.empty());
  EXPECT_EQ(write_document(doc, text), text);
  const RawDocument fresh = read_document(write_document(doc, ""), "g.yaml", found);
  EXPECT_TRUE(same_document(doc, fresh)) << write_document(doc, "");
  doc.nodes[0].each[0].second.written.items[0] = "1:4:1";
  EXPECT_FALSE(same_document(doc, fresh));
  Edit edit;
  edit.kind = Edit::Kind::SetParameter;
  edit.node = "c";
  edit.name = "value";
  edit.value = {false, {"7"}, {}};
  EXPECT_NE(edit_document(text, "g.yaml", edit).find("each: {k: \"1:3:1\", of: [a, b]}"), std::string::npos);
  edit = {};
  edit.kind = Edit::Kind::RenameNode;
  edit.node = "c";
  edit.to = "e";
  EXPECT_NE(edit_document(text, "g.yaml", edit).find("\"e[1,a].out\""), std::string::npos)
      << edit_document(text, "g.yaml", edit);
  edit = {};
  edit.kind = Edit::Kind::RemoveNode;
  edit.node = "c";
  EXPECT_EQ(edit_document(text, "g.yaml", edit).find("c["), std::string::npos);
}

TEST(Each, TheSchemaKnowsIt) {
  const auto schema = graph_schema(test::arithmetic());
  for (const auto& node : schema["properties"]["nodes"]["additionalProperties"]["anyOf"])
    EXPECT_EQ(node["properties"]["each"]["minProperties"], 1) << node.dump();
}

// A graph with `each` equals the graph with every element written by hand, for random values.
TEST(Each, EqualsWhatIsWrittenByHand) {
  Random random(11);
  for (int trial = 0; trial < 200; ++trial) {
    const auto list = [&] {
      std::set<int> out;
      for (std::size_t n = 1 + random.below(4); out.size() < n;)
        out.insert(static_cast<int>(random.below(50)) - 20);
      return std::vector<int>(out.begin(), out.end());
    };
    const auto text = [](const std::vector<int>& v) {
      std::string out;
      for (const int n : v) out += (out.empty() ? "" : ", ") + std::to_string(n);
      return "[" + out + "]";
    };
    const auto a = list(), b = list();
    std::string hand = "nodes:\n", wires;
    for (const int x : a)
      hand += "  c" + std::to_string(x) + ": {type: Constant, params: {value: " + std::to_string(x) + "}}\n";
    for (const int x : a)
      for (const int y : b) {
        const std::string name = "d_" + std::to_string(x) + "_" + std::to_string(y);
        hand += "  " + name + ": {type: Clamp, inputs: {in: c" + std::to_string(x) +
                ".out}, params: {low: " + std::to_string(y) + "}}\n";
        wires += (wires.empty() ? "" : ", ") + name + ".out";
      }
    hand += "  sum: {type: Sum, inputs: {in: [" + wires + "]}}\n";
    const Graph each =
        graph_of("nodes:\n  c: {type: Constant, each: {x: " + text(a) +
                 "}, params: {value: '${x}'}}\n  d: {type: Clamp, each: {x: " + text(a) + ", y: " + text(b) +
                 "}, inputs: {in: 'c[${x}].out'}, params: {low: '${y}'}}\n" +
                 "  sum: {type: Sum, inputs: {in: d.out}}\n");
    const Graph byhand = graph_of(hand);
    ASSERT_EQ(each.nodes.size(), byhand.nodes.size());
    for (std::size_t i = 0; i < each.nodes.size(); ++i) {
      const GraphNode &x = each.nodes[i], &y = byhand.nodes[i];
      ASSERT_EQ(x.type, y.type);
      for (const auto& [name, p] : x.parameters) ASSERT_EQ(p.value, y.parameters.at(name).value);
      for (const auto& [port, w] : x.inputs) {
        ASSERT_EQ(w.size(), y.inputs.at(port).size());
        for (std::size_t k = 0; k < w.size(); ++k) ASSERT_EQ(w[k].node, y.inputs.at(port)[k].node);
      }
    }
  }
}

TEST(ElementName, SeparatesNodesAndPorts) {
  EXPECT_EQ(find_port_dot("a[0.5]"), std::string::npos);
  EXPECT_EQ(find_port_dot("a[0.5].out"), 6u);
  EXPECT_EQ(find_port_dot("a.out"), 1u);
  EXPECT_EQ(without_elements("a[0.5]/b[x,#1]"), "a/b");
  EXPECT_EQ(without_elements("a]b["), "a]b[");
  EXPECT_EQ(written_node("a[0.5].out"), "a");
  EXPECT_EQ(written_node("a.out"), "a");
  EXPECT_TRUE(is_named("a[1]/b", "a/b"));
  EXPECT_FALSE(is_named("a[1]/b", "a[2]/b"));
  EXPECT_TRUE(is_node_name("a[0.5]"));
  for (const char* bad : {"", "a b", "a.b", "a[1].b", "a[.", ".a[1]"}) EXPECT_FALSE(is_node_name(bad)) << bad;
}

TEST(ValueRange, ReadsNumbersAndNothingElse) {
  EXPECT_EQ(*read_range("0:3:1", 10), (Names{"0", "1", "2", "3"}));
  EXPECT_EQ(*read_range("0.1:0.35:0.1", 10), (Names{"0.1", "0.2", "0.3"}));
  EXPECT_EQ(*read_range("2:2:1", 1), Names{"2"});
  for (const char* no : {"", "1", "1:2", "1:2:3:4", "a:2:1", "1:2:", " 1:2:1", "1:inf:1", "1:2:1 "})
    EXPECT_FALSE(read_range(no, 10)) << no;
  EXPECT_THROW(read_range("1:2:0", 10), Error);
  EXPECT_THROW(read_range("0:10:1", 10), Error);
  EXPECT_THROW(read_range("0:1e300:1e-300", 10), Error);
}

}  // namespace
}  // namespace terrazzo
