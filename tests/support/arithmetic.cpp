#include "tests/support/arithmetic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "nodes/data/table.h"
#include "nodes/register_nodes.h"
#include "runtime/context.h"

namespace terrazzo::test {
namespace {

Table table(double v) { return {{"value"}, {{v}}}; }
double in(const Context& c, const std::string& port) { return c.input<Table>(port).number(0, "value"); }

NodeType type(const std::string& name, void (*compute)(Context&)) {
  return NodeType(name, 1).doc_("test").output("out", "Table", "result").compute_(compute);
}

}  // namespace

const Registry& arithmetic() {
  static const Registry registry = [] {
    Registry r;
    r.add(type("Constant", [](Context& c) { c.output("out", table(c.number("value"))); })
              .parameter(Parameter::number("value", 1).range(-1000, 1000).doc_("v"))
              .parameter(Parameter::text("note", "").doc_("n")));
    r.add(type("Add", [](Context& c) { c.output("out", table(in(c, "a") + in(c, "b"))); })
              .input("a", "Table", "a")
              .input("b", "Table", "b"));
    r.add(type("Clamp",
               [](Context& c) {
                 c.output("out", table(std::clamp(in(c, "in"), c.number("low"), c.number("high"))));
               })
              .input("in", "Table", "in")
              .was("Limit")
              .parameter(Parameter::number("low", 0).was("minimum").doc_("l"))
              .parameter(Parameter::number("high", 1).doc_("h")));
    r.add(type("Sum", [](Context& c) {
            double sum = 0;
            for (const auto& v : c.list("in")) sum += v.as<Table>().number(0, "value");
            c.output("out", table(sum));
          }).input_list("in", {"Table"}, "in"));
    r.add(type("SumInTurn",
               [](Context& c) {  // metric `alive`: the largest number of values in memory at a time
                 double sum = 0;
                 std::ptrdiff_t alive = 0;
                 std::vector<std::weak_ptr<const void>> all;
                 for (std::size_t k = 0; k < c.count("in"); ++k) {
                   const Value v = c.nth("in", k);
                   sum += v.as<Table>().number(0, "value");
                   all.push_back(v.share());
                   alive = std::max(alive, std::count_if(all.begin(), all.end(),
                                                         [](const auto& one) { return !one.expired(); }));
                 }
                 c.metric("alive", static_cast<double>(alive));
                 c.output("out", table(sum));
               })
              .input_list("in", {"Table"}, "in")
              .one_at_a_time());
    r.add(type("ListInTurn",
               [](Context& c) { c.output("out", table(static_cast<double>(c.list("in").size()))); })
              .input_list("in", {"Table"}, "in")
              .one_at_a_time());
    r.add(type("FileSize", [](Context& c) {
            double sum = 0;
            for (const auto& f : c.files("path")) sum += static_cast<double>(std::filesystem::file_size(f));
            c.output("out", table(sum));
          }).parameter(Parameter::input_path("path").doc_("p")));
    r.add(type("Fail",
               [](Context& c) {
                 throw Error("no-luck", "it does not work with " + std::to_string(c.integer("level")),
                             "try another")
                     .parameter("level");
               })
              .optional_input("in", {"Table"}, "in")
              .parameter(Parameter::integer("level", 1).doc_("l")));
    r.add(type("Endless", [](Context& c) {
      while (true) {
        c.work().check();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }));
    r.add(type("Sketch",
               [](Context& c) {  // half of `value`, then all of it, or an endless wait
                 c.preview("out", table(c.number("value") / 2));
                 while (c.number("wait") != 0) {
                   c.work().check();
                   std::this_thread::sleep_for(std::chrono::milliseconds(1));
                 }
                 c.output("out", table(c.number("value")));
               })
              .parameter(Parameter::number("value", 0).doc_("v"))
              .parameter(Parameter::number("wait", 0).doc_("w")));
    r.add(type("Big",
               [](Context& c) {  // a table with many rows, all equal to `value`
                 Table t{{"value"}, {}};
                 t.rows.assign(static_cast<std::size_t>(c.integer("rows")), {c.number("value")});
                 c.output("out", t);
               })
              .optional_input("in", {"Table"}, "waited for")
              .parameter(Parameter::integer("rows", 1000).range(1, 1e7).doc_("r"))
              .parameter(Parameter::number("value", 1).range(-1000, 1000).doc_("v")));
    r.add(NodeType("Write", 1)
              .doc_("test")
              .input("in", "Table", "in")
              .writes_files_()
              .parameter(Parameter::output_path("path").doc_("p"))
              .compute_([](Context& c) {
                c.write_file(c.text("path"),
                             [&](const std::filesystem::path& p) { std::ofstream(p) << in(c, "in"); });
              }));
    return r;
  }();
  return registry;
}

const ValueTypes& value_types() {
  static const ValueTypes types = [] {
    ValueTypes t;
    register_value_types(t);
    return t;
  }();
  return types;
}

Graph graph_of(const std::string& text, const Overrides& overrides) {
  Diagnostics found;
  Graph g = load_graph_text("terrazzo: 1\n" + text, "test.yaml", arithmetic(), overrides, found);
  for (const auto& d : found) ADD_FAILURE() << d.text();
  return g;
}

double number_of(const Value& v) { return v.as<Table>().number(0, "value"); }

int count(const RunResult& run, Status s) {
  int n = 0;
  for (const auto& node : run.nodes) n += node.status == s;
  return n;
}

std::vector<std::string> paths(const Graph& g, const RunResult& run, Status s) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    if (run.nodes[i].status == s) out.push_back(g.nodes[i].path);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace terrazzo::test
