#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::arithmetic;
using test::graph_of;

struct Found {
  Diagnostics all;
  // The message at line:column, or a list of all messages.
  std::string at(int line, int column) const {
    for (const auto& d : all)
      if (d.place.line == line && d.place.column == column) return d.message;
    std::string list;
    for (const auto& d : all) list += d.text() + "\n";
    return "no message there, but:\n" + list;
  }
};

Found check(const std::string& text, const Overrides& overrides = {}) {
  Found f;
  load_graph_text(text, "g.yaml", arithmetic(), overrides, f.all);
  return f;
}

TEST(LoadGraph, TwoNodesMayNotWriteOneFile) {
  const std::string start =
      "terrazzo: 1\n"
      "nodes:\n"
      "  a: {type: Constant, params: {value: 1}}\n";
  const Found same = check(start +
                           "  w: {type: Write, inputs: {in: a.out}, params: {path: x/t.csv}}\n"
                           "  v: {type: Write, inputs: {in: a.out}, params: {path: x/../x/./t.csv}}\n");
  ASSERT_EQ(same.all.size(), 1u);
  EXPECT_EQ(same.all[0].code, "same-file");
  EXPECT_EQ(same.at(5, 56), "'w' and 'v' both write 'x/../x/./t.csv'");
  const Found each =
      check(start + "  w: {type: Write, each: {k: [1, 2]}, inputs: {in: a.out}, params: {path: t.csv}}\n");
  ASSERT_EQ(each.all.size(), 1u);
  EXPECT_EQ(each.all[0].code, "same-file");
  EXPECT_TRUE(
      check(start +
            "  w: {type: Write, each: {k: [1, 2]}, inputs: {in: a.out}, params: {path: \"${k}.csv\"}}\n")
          .all.empty());
}

TEST(LoadGraph, NamesThatDifferOnlyInCaseAreOneFile) {
  const std::string start = "terrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 1}}\n";
  const Found f = check(start +
                        "  w: {type: Write, inputs: {in: a.out}, params: {path: x/t.csv}}\n"
                        "  v: {type: Write, inputs: {in: a.out}, params: {path: x/T.csv}}\n");
  ASSERT_EQ(f.all.size(), 1u);
  EXPECT_EQ(f.all[0].code, "same-file");
  EXPECT_EQ(f.at(5, 56),
            "'w' and 'v' write 'x/t.csv' and 'x/T.csv', which are one file where upper and lower case are "
            "the same");
}

TEST(LoadGraph, NamesOfTheProgramsOwnFilesAreReserved) {
  const std::string start = "terrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 1}}\n";
  for (const std::string path :
       {"report.json", "./report.json", "x/../Sweep.CSV", "sweep.json", "sweep.png"}) {
    const Found f = check(start + "  w: {type: Write, inputs: {in: a.out}, params: {path: " + path + "}}\n");
    ASSERT_EQ(f.all.size(), 1u) << path;
    EXPECT_EQ(f.all[0].code, "reserved-name") << path;
    EXPECT_EQ(f.all[0].parameter, "path") << path;
  }
  EXPECT_TRUE(
      check(start + "  w: {type: Write, inputs: {in: a.out}, params: {path: x/report.json}}\n").all.empty());
}

TEST(LoadGraph, TenMistakesTenMessagesWithTheirPlaces) {
  const Found f = check(
      "terrazzo: 1\n"
      "nmae: x\n"  // 2:1 unknown key
      "parameters:\n"
      "  k: {type: nmber, default: 1}\n"  // 4:13 unknown parameter type
      "nodes:\n"
      "  a: {type: Constnt}\n"                                 // 6:13 unknown node type
      "  b: {type: Constant, params: {valeu: 2}}\n"            // 7:39 unknown parameter
      "  c: {type: Constant, params: {value: 2000}}\n"         // 8:39 range
      "  d: {type: Constant, params: {value: abc}}\n"          // 9:39 wrong type
      "  e: {type: Add, inputs: {a: b.out, b: nobody.out}}\n"  // 10:40 unknown node
      "  f: {type: Add, inputs: {a: b.aut, b: c.out}}\n"       // 11:30 unknown port
      "  g: {type: Add, inputs: {a: b.out}}\n"                 // 12:3 missing input
      "  b: {type: Constant}\n");                              // 13:3 duplicate
  EXPECT_EQ(f.all.size(), 10u);
  EXPECT_NE(f.at(2, 1).find("did you mean 'name'"), std::string::npos) << f.at(2, 1);
  EXPECT_NE(f.at(4, 13).find("did you mean 'number'"), std::string::npos) << f.at(4, 13);
  EXPECT_NE(f.at(6, 13).find("did you mean 'Constant'"), std::string::npos) << f.at(6, 13);
  EXPECT_NE(f.at(7, 39).find("did you mean 'value'"), std::string::npos) << f.at(7, 39);
  EXPECT_NE(f.at(8, 39).find("between -1000 and 1000"), std::string::npos) << f.at(8, 39);
  EXPECT_NE(f.at(9, 39).find("'abc' is not a number"), std::string::npos) << f.at(9, 39);
  EXPECT_NE(f.at(10, 40).find("no node 'nobody'"), std::string::npos) << f.at(10, 40);
  EXPECT_NE(f.at(11, 30).find("did you mean 'out'"), std::string::npos) << f.at(11, 30);
  EXPECT_NE(f.at(12, 3).find("needs the input 'b'"), std::string::npos) << f.at(12, 3);
  EXPECT_NE(f.at(13, 3).find("appears twice"), std::string::npos) << f.at(13, 3);
}

TEST(LoadGraph, BrokenYamlAndForeignFiles) {
  EXPECT_TRUE(has_errors(check("terrazzo: 1\nnodes: {a: [").all));
  EXPECT_TRUE(has_errors(check("").all));
  EXPECT_TRUE(has_errors(check("just words").all));
  EXPECT_NE(check("terrazzo: 2\nnodes: {}\n").at(1, 1).find("version '2'"), std::string::npos);
  Diagnostics found;
  load_graph("/nowhere/at/all.yaml", arithmetic(), {}, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "no-file");
}

TEST(LoadGraph, CyclesAreNamed) {
  const Found f = check(
      "terrazzo: 1\nnodes:\n"
      "  a: {type: Clamp, inputs: {in: b.out}}\n"
      "  b: {type: Clamp, inputs: {in: a.out}}\n");
  ASSERT_EQ(f.all.size(), 1u);
  EXPECT_EQ(f.all[0].code, "cycle");
}

TEST(LoadGraph, ParametersAreSubstitutedAndOverridden) {
  const std::string text =
      "parameters: {v: {type: number, default: 3}}\n"
      "nodes:\n"
      "  a: {type: Constant, params: {value: '${v}', note: 'v is ${v}'}}\n";
  const Graph plain = graph_of(text);
  EXPECT_EQ(std::get<double>(plain.nodes[0].parameters.at("value").value), 3.0);
  EXPECT_EQ(std::get<std::string>(plain.nodes[0].parameters.at("note").value), "v is 3");
  const Graph by_param = graph_of(text, {{}, {{"v", "4"}}});
  EXPECT_EQ(std::get<double>(by_param.nodes[0].parameters.at("value").value), 4.0);
  const Graph by_set = graph_of(text, {{{"a.value", "5"}}, {{"v", "4"}}});
  EXPECT_EQ(std::get<double>(by_set.nodes[0].parameters.at("value").value), 5.0);
  for (const auto& wrong :
       {Overrides{{{"b.value", "5"}}, {}}, Overrides{{{"a.vale", "5"}}, {}}, Overrides{{}, {{"w", "1"}}},
        Overrides{{}, {{"v", "x"}}}, Overrides{{{"a", "5"}}, {}}}) {
    Diagnostics found;
    load_graph_text("terrazzo: 1\n" + text, "g.yaml", arithmetic(), wrong, found);
    EXPECT_EQ(found.size(), 1u);
  }
}

class Subgraphs : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << "terrazzo: 1\n" << text;
  }
  Graph load(const std::string& name, const Overrides& o = {}) {
    found.clear();
    return load_graph(folder / name, arithmetic(), o, found);
  }
  std::filesystem::path folder = test::temporary_folder();
  Diagnostics found;
};

TEST_F(Subgraphs, AreUnfoldedWithInputsOutputsAndParameters) {
  write("inner.yaml",
        "parameters: {high: {type: number, default: 10}}\n"
        "nodes:\n"
        "  source: {type: Constant, params: {value: 7}}\n"
        "  clamp: {type: Clamp, inputs: {in: source.out}, params: {high: '${high}'}}\n"
        "inputs: {value: source.out}\n"
        "outputs: {result: clamp.out}\n");
  write("outer.yaml",
        "nodes:\n"
        "  big: {type: Constant, params: {value: 100}}\n"
        "  limit: {graph: inner.yaml, inputs: {value: big.out}, params: {high: 50}}\n"
        "  alone: {graph: inner.yaml}\n"
        "  sum: {type: Add, inputs: {a: limit.result, b: alone.result}}\n");
  const auto evaluate = [&](const Overrides& o) {
    const Graph g = load("outer.yaml", o);
    for (const auto& d : found) ADD_FAILURE() << d.text();
    Store store(test::value_types(), {});
    FileHashes hashes;
    Evaluator e(test::value_types(), store, hashes);
    const RunResult r = e.run(g, {});
    return test::number_of(e.value(g, r, g.wire_to("sum.out")));
  };
  EXPECT_EQ(evaluate({}), 57);
  EXPECT_EQ(evaluate({{{"limit.high", "20"}}, {}}), 27);         // the subgraph's parameter
  EXPECT_EQ(evaluate({{{"alone/source.value", "1"}}, {}}), 51);  // a node inside
}

TEST_F(Subgraphs, MistakesInsideKeepTheirFile) {
  write("inner.yaml", "nodes:\n  c: {type: Constant, params: {value: 5000}}\noutputs: {out: c.out}\n");
  write("outer.yaml",
        "nodes:\n  s: {graph: inner.yaml, params: {x: 1}}\n  t: {graph: gone.yaml}\n  u: {graph: "
        "outer.yaml}\n");
  load("outer.yaml");
  ASSERT_EQ(found.size(), 4u);
  bool inside = false;
  for (const auto& d : found)
    inside |= d.place.file == (folder / "inner.yaml").string() && d.place.line == 3 && d.node == "s/c";
  EXPECT_TRUE(inside);
}

TEST_F(Subgraphs, PathsAreRelativeToTheFileThatNamesThem) {
  std::filesystem::create_directories(folder / "lib");
  std::ofstream(folder / "lib" / "data.txt") << "12345";
  std::ofstream(folder / "other.txt") << "123";
  write("lib/inner.yaml",
        "parameters: {file: {type: path, default: data.txt}}\n"
        "nodes: {f: {type: FileSize, params: {path: '${file}'}}}\noutputs: {out: f.out}\n");
  write("outer.yaml",
        "nodes:\n  s: {graph: lib/inner.yaml}\n  t: {graph: lib/inner.yaml, params: {file: "
        "other.txt}}\noutputs: {s: s.out, t: t.out}\n");
  const Graph g = load("outer.yaml");
  for (const auto& d : found) ADD_FAILURE() << d.text();
  Store store(test::value_types(), {});
  FileHashes hashes;
  Evaluator e(test::value_types(), store, hashes);
  const RunResult r = e.run(g, {});
  EXPECT_EQ(test::number_of(e.value(g, r, g.wire_to("s"))), 5);
  EXPECT_EQ(test::number_of(e.value(g, r, g.wire_to("t"))), 3);
}

}  // namespace
}  // namespace terrazzo
