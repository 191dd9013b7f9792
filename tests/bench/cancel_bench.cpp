// Measures the latency of cancellation: every node's example, canceled at moments spread over its run. The
// goal is at most 200 ms; the baseline `whole_ms` is the duration of the whole run.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "nodes/register_nodes.h"
#include "runtime/session.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

void cancel(benchmark::State& state, const fs::path& example) {
  Registry registry;
  register_nodes(registry);
  ValueTypes types;
  register_value_types(types);
  double whole = 0, worst = 0;
  const auto evaluate = [&](double after) {
    Session session(registry, types, {.output_folder = fs::temp_directory_path() / "terrazzo-cancel-bench"});
    if (has_errors(session.open(example))) return state.SkipWithError("the example has errors");
    const auto start = Clock::now();
    const auto evaluation = session.evaluate();
    if (after >= 0) {
      std::this_thread::sleep_for(std::chrono::duration<double>(after));
      const auto then = Clock::now();
      evaluation->cancel();
      evaluation->wait();
      worst = std::max(worst, since(then));
    } else {
      evaluation->wait();
      whole = since(start);
    }
  };
  for (auto _ : state) {
    evaluate(-1);
    constexpr int moments = 10;
    for (int k = 0; k < moments; ++k) evaluate(whole * (k + 0.5) / moments);
  }
  state.counters["whole_ms"] = 1000 * whole;
  state.counters["worst_ms"] = 1000 * worst;
}

const int registered = [] {
  for (const auto& e : fs::recursive_directory_iterator(fs::path(TERRAZZO_SOURCE) / "nodes"))
    if (const fs::path example = e.path(); example.filename() == "example.yaml")
      benchmark::RegisterBenchmark(("cancel/" + example.parent_path().filename().string()).c_str(),
                                   [example](benchmark::State& s) { cancel(s, example); })
          ->Unit(benchmark::kMillisecond)
          ->Iterations(1);
  return 0;
}();

}  // namespace
}  // namespace terrazzo
