// Overhead of the evaluator per node, with a cold and a full cache. The baseline is a bare oneTBB flow graph
// with the same topology.
#include <benchmark/benchmark.h>
#include <tbb/flow_graph.h>

#include <fmt/format.h>

#include "nodes/data/table.h"
#include "nodes/register_nodes.h"
#include "runtime/context.h"
#include "runtime/evaluate.h"

namespace terrazzo {
namespace {

constexpr int length = 1000, side = 100;

const Registry& registry() {
  static const Registry r = [] {
    Registry x;
    x.add(NodeType("Start", 1)
              .doc_("bench")
              .output("out", "Table", "x")
              .parameter(Parameter::number("value", 0).doc_("v"))
              .compute_([](Context& c) {
                c.output("out", Table{{"v"}, {{c.number("value")}}});
              }));
    x.add(NodeType("Next", 1)
              .doc_("bench")
              .input("in", "Table", "x")
              .output("out", "Table", "x")
              .compute_([](Context& c) {
                c.output("out", Table{{"v"}, {{c.input<Table>("in").number(0, "v") + 1}}});
              }));
    x.add(NodeType("Join", 1)
              .doc_("bench")
              .input("a", "Table", "x")
              .input("b", "Table", "x")
              .output("out", "Table", "x")
              .compute_([](Context& c) {
                c.output("out", Table{{"v"},
                                      {{c.input<Table>("a").number(0, "v") +
                                        c.input<Table>("b").number(0, "v") / 2 + 1e-3}}});
              }));
    return x;
  }();
  return r;
}

const ValueTypes& types() {
  static const ValueTypes t = [] {
    ValueTypes x;
    register_value_types(x);
    return x;
  }();
  return t;
}

Graph chain(int start) {
  std::string text =
      fmt::format("terrazzo: 1\nnodes:\n  n0: {{type: Start, params: {{value: {}}}}}\n", start);
  for (int i = 1; i < length; ++i)
    text += fmt::format("  n{}: {{type: Next, inputs: {{in: n{}.out}}}}\n", i, i - 1);
  Diagnostics found;
  return load_graph_text(text, "chain.yaml", registry(), {}, found);
}

// A square grid in which every node depends on the nodes above and to the left.
Graph grid(int start) {
  std::string text = "terrazzo: 1\nnodes:\n";
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto at = [](int x, int y) { return fmt::format("n{}_{}", x, y); };
      if (x == 0 && y == 0)
        text += fmt::format("  n0_0: {{type: Start, params: {{value: {}}}}}\n", start);
      else if (x == 0 || y == 0)
        text += fmt::format("  {}: {{type: Next, inputs: {{in: {}.out}}}}\n", at(x, y),
                            x == 0 ? at(x, y - 1) : at(x - 1, y));
      else
        text += fmt::format("  {}: {{type: Join, inputs: {{a: {}.out, b: {}.out}}}}\n", at(x, y),
                            at(x - 1, y), at(x, y - 1));
    }
  Diagnostics found;
  return load_graph_text(text, "grid.yaml", registry(), {}, found);
}

using Make = Graph (*)(int);

void per_node(benchmark::State& state, std::size_t nodes) {
  state.counters["per_node"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(nodes),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

// Checks that the timed run did the expected work.
void demand(benchmark::State& state, const RunResult& r, Status status) {
  std::size_t n = 0;
  for (const auto& node : r.nodes) n += node.status == status;
  // The grid is symmetric, and equal nodes are computed once.
  if (n * 2 < r.nodes.size() || r.nodes.empty()) state.SkipWithError("nodes were not computed");
}

void cold(benchmark::State& state, Make make) {
  int start = 0;
  std::size_t nodes = 0;
  for (auto _ : state) {
    state.PauseTiming();
    {
      const Graph g = make(++start);
      Store store(types(), {});
      FileHashes hashes;
      Evaluator e(types(), store, hashes);
      state.ResumeTiming();
      const RunResult r = e.run(g, {});
      state.PauseTiming();
      nodes = r.nodes.size();
      demand(state, r, Status::Computed);
    }
    state.ResumeTiming();
  }
  per_node(state, nodes);
}

void cached(benchmark::State& state, Make make) {
  const Graph g = make(0);
  Store store(types(), {});
  FileHashes hashes;
  Evaluator e(types(), store, hashes);
  e.run(g, {});
  for (auto _ : state) demand(state, e.run(g, {}), Status::Memory);
  per_node(state, g.nodes.size());
}

// The baseline: the same topology without the evaluator.
void tbb_alone(benchmark::State& state, Make make) {
  const Graph shape = make(0);
  for (auto _ : state) {
    tbb::flow::graph g;
    std::vector<std::unique_ptr<tbb::flow::continue_node<tbb::flow::continue_msg>>> nodes;
    std::vector<double> values(shape.nodes.size(), 0);
    for (std::size_t i = 0; i < shape.nodes.size(); ++i)
      nodes.push_back(std::make_unique<tbb::flow::continue_node<tbb::flow::continue_msg>>(
          g, [&values, i](const tbb::flow::continue_msg& m) {
            values[i] += 1;
            return m;
          }));
    for (std::size_t i = 0; i < shape.nodes.size(); ++i)
      for (const auto& [port, wires] : shape.nodes[i].inputs)
        for (const auto& w : wires) tbb::flow::make_edge(*nodes[static_cast<std::size_t>(w.node)], *nodes[i]);
    nodes[0]->try_put({});
    g.wait_for_all();
    benchmark::DoNotOptimize(values.data());
  }
  per_node(state, shape.nodes.size());
}

BENCHMARK_CAPTURE(cold, runtime_chain, chain)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(cached, runtime_chain, chain)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(tbb_alone, runtime_chain, chain)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(cold, runtime_grid, grid)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(cached, runtime_grid, grid)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(tbb_alone, runtime_grid, grid)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace terrazzo
