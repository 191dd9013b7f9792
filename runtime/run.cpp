// The order of the nodes in a run.
#include "runtime/run.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "graph/exception_text.h"
#include "graph/numeric_environment.h"

namespace terrazzo {

Run::Run(Evaluator& e, const Graph& graph, const RunOptions& options)
    : e_(e), graph_(graph), options_(options), states_(graph.nodes.size()) {
  result_.nodes.resize(graph.nodes.size());
}

int Run::threads() const {
  return std::max(
      options_.threads > 0 ? options_.threads : static_cast<int>(std::thread::hardware_concurrency()), 1);
}

bool Run::cancelled(int i) const {
  return (options_.cancel && *options_.cancel) || (options_.cancel_node && (*options_.cancel_node)[i]);
}

bool Run::run_is_cancelled() const {
  return (options_.cancel && *options_.cancel) || (options_.cancel_all && *options_.cancel_all);
}

Work Run::work(int i, const Work::Report* report) const {
  return Work(options_.cancel, report, options_.cancel_node ? &(*options_.cancel_node)[i] : nullptr);
}

RunResult Run::run() {
  const NumericEnvironment numbers;
  const auto start = std::chrono::steady_clock::now();
  const auto targets = options_.targets.empty() ? graph_.sinks() : options_.targets;
  const auto needed = needed_nodes(graph_, targets);
  std::vector<int> ready;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (!needed[i]) continue;
    int sources = 0;
    for (const auto& [port, wires] : graph_.nodes[i].inputs)
      for (const auto& w : wires) {
        ++sources;
        states_[w.node].consumers.push_back(static_cast<int>(i));
      }
    states_[i].waiting = sources;
    if (sources == 0) ready.push_back(i);
  }
  for (auto& s : states_) s.users = static_cast<int>(s.consumers.size());
  // TBB's default limit is the number of cores, but the user may ask for more threads.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads()));
  arena_.emplace(threads());
  mark_.before();
  (*arena_)->execute([&] {
    for (const int i : ready) group_.run([this, i] { visit(i); });
    group_.wait();
  });
  mark_.after();
  for (std::size_t i = 0; i < states_.size(); ++i)
    if (states_[i].seconds_again > 0) {
      result_.nodes[i].status = Status::Computed;
      result_.nodes[i].seconds = states_[i].seconds_again;
    }
  result_.without_result = std::ranges::all_of(targets, [&](int t) { return result(t).tolerated; });
  result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return std::move(result_);
}

void Run::visit(int i) {
  mark_.after();
  const NumericEnvironment numbers;  // an arena sets no locale
  try {
    if (!evaluate(i)) return;  // visited again once another node or run has computed the same key
  } catch (const Cancelled&) {
    result(i).status = Status::Cancelled;
  } catch (const Error& error) {
    fail(i, error);
  } catch (const std::exception& error) {  // such as std::bad_alloc: only this node fails
    fail(i, Error("failed", exception_text(error)));
  }
  tell([&](Observer& o) { o.finished(i, result(i)); });
  for (const auto& [port, wires] : node(i).inputs)
    for (const auto& w : wires)
      if (--state(w.node).users == 0) {
        const std::lock_guard lock(state(w.node).mutex);
        state(w.node).values.clear();
      }
  mark_.before();
  for (const int c : state(i).consumers)
    if (--state(c).waiting == 0) group_.run([this, c] { visit(c); });
}

void Run::fail(int i, const Error& error) {
  NodeResult& r = result(i);
  r.status = Status::Failed;
  r.error = placed(error, node(i));
  r.tolerated = !node(i).may_fail.empty();
  if (r.tolerated) r.error->severity = Severity::Warning;
}

std::optional<Run::Inputs> Run::inputs_of(int i) {
  Inputs inputs;
  bool left_out = false, sources_failed = false, all_tolerated = true;
  for (const auto& [port, wires] : node(i).inputs)
    for (const auto& w : wires) {
      const NodeResult& source = result(w.node);
      if (source.status == Status::Cancelled) throw Cancelled();
      if (is_left_out(graph_, result_, node(i), w)) {
        left_out = true;
      } else if (source.status == Status::Failed || source.status == Status::Skipped) {
        sources_failed = true;
        all_tolerated = all_tolerated && source.tolerated;
      } else {
        inputs[port].push_back(source.outputs.at(w.port));
      }
    }
  for (const Port& port : node(i).type->inputs)
    if (!port.optional && !inputs.count(port.name)) sources_failed = true;
  if (left_out && inputs.empty()) sources_failed = true;
  if (!sources_failed) return inputs;
  result(i).tolerated = all_tolerated || !node(i).may_fail.empty();
  return {};
}

bool Run::evaluate(int i) {
  NodeResult& r = result(i);
  if (cancelled(i)) throw Cancelled();
  const auto found = inputs_of(i);
  if (!found) {
    r.status = Status::Skipped;
    return true;
  }
  const Inputs& inputs = *found;
  // If a file changes while the node reads it, the value belongs to no key, so try again.
  for (int attempt = 0; attempt < 3; ++attempt) {
    state(i).files = input_files(node(i), e_.hashes_, options_.memory);
    r.read = state(i).files.read;
    r.key = action_key(node(i), state(i).files.hashes, inputs);
    r.record = record_key(*node(i).type, r.key, options_.output_folder);
    if (use_cached(i)) return true;
    switch (compute_alone(i, inputs)) {
      case Outcome::Done:
        return true;
      case Outcome::Elsewhere:
        return false;
      case Outcome::FilesChanged:
        break;
    }
  }
  throw Error("file-changed", "an input file changed while it was read, three times in a row",
              "run again once no other program writes to it")
      .parameter(state(i).files.paths.begin()->first);
}

}  // namespace terrazzo
