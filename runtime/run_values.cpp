// Values of nodes that ran: from memory, from the disk, or computed again.
#include <chrono>

#include "runtime/run.h"

namespace terrazzo {

Value Run::fetch(Evaluator& e, const Graph& graph, const RunResult& result, const Wire& wire,
                 const RunOptions& options) {
  Run again(e, graph, options);
  again.result_ = result;
  again.arena_.emplace(again.threads());
  Value v;
  (*again.arena_)->execute([&] { v = again.value_of(wire); });  // computes it again if it was lost
  return v;
}

Value Run::value_of(const Wire& w, bool keep) {
  State& s = state(w.node);
  const NodeResult& r = result(w.node);
  if (!r.outputs.count(w.port))
    throw Error("no-value", "'" + node(w.node).path + "' has no result, because it failed or was skipped");
  const OutputRecord& wanted = r.outputs.at(w.port);
  {
    const std::lock_guard lock(s.mutex);
    if (const auto it = s.values.find(w.port); it != s.values.end()) return it->second;
  }
  if (Value v = e_.store_.get_value(wanted, r.cached_seconds, keep)) return v;
  // The record is known but the value is lost or damaged, so recompute the source. Isolated, so that this
  // thread cannot pick up a task that waits for the same source, which would deadlock.
  Value v;
  tbb::this_task_arena::isolate([&] {
    const std::lock_guard lock(s.mutex);
    if (const auto it = s.values.find(w.port); it != s.values.end()) {
      v = it->second;
      return;
    }
    if ((v = e_.store_.get_value(wanted, r.cached_seconds))) return;
    compute_again(w.node);
    v = s.values.at(w.port);
  });
  return v;
}

void Run::compute_again(int i) {
  State& s = state(i);
  const NodeResult& r = result(i);
  tell([&](Observer& o) { o.started(i); });
  const auto start = std::chrono::steady_clock::now();
  s.files = input_files(node(i), e_.hashes_, options_.memory);
  const Inputs inputs = inputs_of(i).value();
  const auto changed = [&] {
    return Error(placed(Error("file-changed",
                              "an input file changed during the run, so a lost cached value cannot be "
                              "recomputed",
                              "run again"),
                        node(i)));
  };
  if (action_key(node(i), s.files.hashes, inputs) != r.key) throw changed();
  ComputeResult again = compute_node(request(i, work(i, nullptr)));
  if (files_changed(i)) throw changed();
  s.seconds_again = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::map<std::string, OutputRecord> outputs;
  bool in_record = true;
  for (auto& [port, value] : again.outputs) {
    const OutputRecord& before = r.outputs.at(port);
    const OutputRecord& now = outputs[port] = e_.store_.put_value(value, s.seconds_again);
    in_record = in_record && (before.small || !now.small);
    if (now != before) {
      e_.store_.drop_action(r.record);
      throw Error(placed(
          Error("not-deterministic", "the recomputed output '" + port + "' differs from its cached record",
                "the record was removed from the cache: run again"),
          node(i)));
    }
    s.values[port] = std::move(value);
  }
  if (in_record) return;
  // The record is of a version that gave small values files of their own.
  Tier tier;
  if (const auto record = e_.store_.find_action(r.record, tier)) {
    auto renewed = std::make_shared<ActionRecord>(*record);
    renewed->outputs = std::move(outputs);
    e_.store_.put_action(r.record, std::move(renewed));
  }
}

}  // namespace terrazzo
