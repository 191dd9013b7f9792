// Overhead of the evaluator per node, cold and fully cached, beside oneTBB's flow graph alone on the same
// topology.
#include <benchmark/benchmark.h>
#include <tbb/flow_graph.h>

#include <fmt/format.h>

#include "nodes/data/table.h"
#include "nodes/register_nodes.h"
#include "runtime/context.h"
#include "runtime/evaluate.h"

namespace terrazzo {
namespace {

constexpr int length = 1000;

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

void per_node(benchmark::State& state) {
  state.counters["per node"] = benchmark::Counter(static_cast<double>(state.iterations()) * length,
                                                  benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void runtime_chain_cold(benchmark::State& state) {
  int start = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const Graph g = chain(++start);
    Store store(types(), {});
    FileHashes hashes;
    Evaluator e(types(), store, hashes);
    state.ResumeTiming();
    benchmark::DoNotOptimize(e.run(g, {}));
  }
  per_node(state);
}
BENCHMARK(runtime_chain_cold)->Unit(benchmark::kMillisecond);

void runtime_chain_cached(benchmark::State& state) {
  const Graph g = chain(0);
  Store store(types(), {});
  FileHashes hashes;
  Evaluator e(types(), store, hashes);
  e.run(g, {});
  for (auto _ : state) benchmark::DoNotOptimize(e.run(g, {}));
  per_node(state);
}
BENCHMARK(runtime_chain_cached)->Unit(benchmark::kMillisecond);

void runtime_chain_tbb_alone(benchmark::State& state) {
  for (auto _ : state) {
    tbb::flow::graph g;
    std::vector<std::unique_ptr<tbb::flow::function_node<double, double>>> nodes;
    for (int i = 0; i < length; ++i)
      nodes.push_back(
          std::make_unique<tbb::flow::function_node<double, double>>(g, 1, [](double v) { return v + 1; }));
    for (int i = 1; i < length; ++i)
      tbb::flow::make_edge(*nodes[static_cast<std::size_t>(i - 1)], *nodes[static_cast<std::size_t>(i)]);
    nodes[0]->try_put(0);
    g.wait_for_all();
  }
  per_node(state);
}
BENCHMARK(runtime_chain_tbb_alone)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace terrazzo
