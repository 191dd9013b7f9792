#include "runtime/evaluate.h"

#include <tbb/global_control.h>
#include <tbb/task_group.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "graph/write_graph.h"
#include "runtime/arena.h"
#include "runtime/compute_node.h"
#include "runtime/files.h"
#include "runtime/interrupted.h"
#include "runtime/json_text.h"
#include "runtime/thread_marks.h"

namespace terrazzo {
namespace fs = std::filesystem;

bool Evaluator::begin(const Hash& key, const std::function<std::function<void()>()>& later) {
  const std::lock_guard lock(mutex_);
  const auto [it, mine] = busy_.try_emplace(key);
  if (!mine) it->second.push_back(later());
  return mine;
}

void Evaluator::end(const Hash& key) {
  std::vector<std::function<void()>> waiting;
  {
    const std::lock_guard lock(mutex_);
    const auto it = busy_.find(key);
    waiting = std::move(it->second);
    busy_.erase(it);
  }
  for (const auto& resume : waiting) resume();
}

// One run. Every node is a task that starts when its sources are done.
class Run {
 public:
  Run(Evaluator& e, const Graph& graph, const RunOptions& options)
      : e_(e), graph_(graph), options_(options), states_(graph.nodes.size()) {
    result_.nodes.resize(graph.nodes.size());
  }

  RunResult run() {
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
          states_[static_cast<std::size_t>(w.node)].consumers.push_back(static_cast<int>(i));
        }
      states_[i].waiting = sources;
      if (sources == 0) ready.push_back(static_cast<int>(i));
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
      if (states_[i].seconds_again > 0)
        result_.nodes[i].status = Status::Computed, result_.nodes[i].seconds = states_[i].seconds_again;
    result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return std::move(result_);
  }

  // Implements Evaluator::value().
  static Value fetch(Evaluator& e, const Graph& graph, const RunResult& result, const Wire& wire,
                     const RunOptions& options) {
    Run again(e, graph, options);
    again.result_ = result;
    again.arena_.emplace(again.threads());
    Value v;
    (*again.arena_)->execute([&] { v = again.value_of(wire); });  // computes it again if it was lost
    return v;
  }

 private:
  struct State {
    std::atomic<int> waiting{0};
    std::atomic<int> users{0};  // consumers that may still need a value
    std::vector<int> consumers;
    std::map<std::string, Value> values;  // kept while `users` > 0
    std::mutex mutex;                     // protects `values` and recomputation
    double seconds_again = 0;             // time spent recomputing a lost value
    InputFiles files;
  };

  int threads() const {
    return std::max(
        options_.threads > 0 ? options_.threads : static_cast<int>(std::thread::hardware_concurrency()), 1);
  }
  NodeResult& result(int i) { return result_.nodes[static_cast<std::size_t>(i)]; }
  State& state(int i) { return states_[static_cast<std::size_t>(i)]; }
  const GraphNode& node(int i) const { return graph_.nodes[static_cast<std::size_t>(i)]; }

  void visit(int i) {
    mark_.after();
    try {
      if (!evaluate(i)) return;  // visited again once another node or run has computed the same key
    } catch (const Cancelled&) {
      result(i).status = Status::Cancelled;
    } catch (const Error& error) {
      result(i).status = Status::Failed;
      result(i).error = placed(error, node(i));
    } catch (const std::exception& error) {  // such as std::bad_alloc: only this node fails
      result(i).status = Status::Failed;
      result(i).error = placed(Error("failed", error.what()), node(i));
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

  // If the observer throws, it receives no more events, but the run continues.
  template <class Call>
  void tell(Call&& call) {
    if (!options_.observer) return;
    const std::lock_guard lock(observer_mutex_);
    if (!result_.trouble.empty()) return;
    try {
      call(*options_.observer);
    } catch (const std::exception& e) {
      result_.trouble = std::string("the progress display stopped: ") + e.what();
    }
  }

  bool cancelled(int i) const {
    return (options_.cancel && *options_.cancel) ||
           (options_.cancel_node && (*options_.cancel_node)[static_cast<std::size_t>(i)]);
  }
  Work work(int i, const Work::Report* report) const {
    return Work(options_.cancel, report,
                options_.cancel_node ? &(*options_.cancel_node)[static_cast<std::size_t>(i)] : nullptr);
  }

  // Returns false if the key is being computed elsewhere.
  bool evaluate(int i) {
    NodeResult& r = result(i);
    if (cancelled(i)) throw Cancelled();
    std::map<std::string, std::vector<OutputRecord>> inputs;
    for (const auto& [port, wires] : node(i).inputs)
      for (const auto& w : wires) {
        const NodeResult& source = result(w.node);
        if (source.status == Status::Cancelled) throw Cancelled();
        if (source.status == Status::Failed || source.status == Status::Skipped) {
          r.status = Status::Skipped;
          return true;
        }
        inputs[port].push_back(source.outputs.at(w.port));
      }
    // If a file changes while the node reads it, the value belongs to no key, so try again.
    for (int attempt = 0; attempt < 3; ++attempt) {
      state(i).files = input_files(node(i), e_.hashes_);
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

  enum class Outcome { Done, Elsewhere, FilesChanged };
  using Inputs = std::map<std::string, std::vector<OutputRecord>>;

  // Computes the node, unless another task or run is computing the same key.
  Outcome compute_alone(int i, const Inputs& inputs) {
    const NodeResult& r = result(i);
    const auto later = [&]() -> std::function<void()> {
      auto handle = std::make_shared<tbb::task_handle>(group_.defer([this, i] { visit(i); }));
      return [this, handle] { (*arena_)->enqueue(std::move(*handle)); };
    };
    if (!e_.begin(r.record, later)) return Outcome::Elsewhere;
    struct End {
      Evaluator& e;
      const Hash key;
      ~End() { e.end(key); }
    } end{e_, r.record};
    // Another run may have finished between the first lookup and begin().
    if (use_cached(i) || compute(i, inputs)) return Outcome::Done;
    return Outcome::FilesChanged;
  }

  bool use_cached(int i) {
    NodeResult& r = result(i);
    Tier tier;
    const auto record = e_.store_.find_action(r.record, tier);
    if (!record) return false;
    // Written files are cache hits only if their content is unchanged. The name alone proves nothing.
    for (const auto& f : record->files) {
      const auto now = e_.hashes_.hash(options_.output_folder / f.path);
      if (!now || *now != f.content) return false;
    }
    // A value that the store has lost is recomputed only when a consumer needs it.
    r.status = tier == Tier::Memory ? Status::Memory : Status::Disk;
    r.outputs = record->outputs, r.metrics = record->metrics, r.warnings = record->warnings,
    r.files = record->files;
    r.cached_seconds = record->seconds;
    return true;
  }

  // Whether an input file changed since its key was computed.
  bool files_changed(int i) {
    const InputFiles& before = state(i).files;
    if (before.paths.empty()) return false;
    try {
      const InputFiles now = input_files(node(i), e_.hashes_);
      return now.paths != before.paths || now.hashes != before.hashes;
    } catch (const Error&) {
      return true;  // the file is gone; the next attempt reports that
    }
  }

  // Returns false, without storing anything, if an input file changed meanwhile.
  bool compute(int i, const Inputs& inputs) {
    NodeResult& r = result(i);
    tell([&](Observer& o) { o.started(i); });
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const Work::Report report = [this, i](double fraction, const std::string& note) {
      tell([&](Observer& o) { o.progress(i, fraction, note); });
    };
    auto record = std::make_shared<ActionRecord>();
    ComputeRequest q = request(i, work(i, &report));
    record->type = q.type->name, record->version = q.type->version, record->parameters = q.parameters;
    for (const auto& [name, paths] : state(i).files.paths)
      for (std::size_t k = 0; k < paths.size(); ++k)
        record->input_files[name].push_back({paths[k].string(), state(i).files.hashes.at(name)[k]});
    record->inputs = inputs;
    ComputeResult computed;
    try {
      computed = compute_node(std::move(q));
    } catch (const Error&) {
      if (files_changed(i)) return false;
      throw;
    }
    if (files_changed(i)) return false;
    for (auto& [port, value] : computed.outputs) {
      record->outputs[port] = e_.store_.put_value(value, seconds());
      keep(i, port, std::move(value));
    }
    for (const auto& f : computed.files) {
      const auto hash = e_.hashes_.hash(options_.output_folder / f);
      if (!hash) throw Error("write-failed", "the file '" + f + "' disappeared right after it was written");
      record->files.push_back({f, *hash});
    }
    record->metrics = std::move(computed.metrics), record->warnings = std::move(computed.warnings);
    r.seconds = record->seconds = seconds();
    r.outputs = record->outputs, r.metrics = record->metrics, r.warnings = record->warnings,
    r.files = record->files;
    r.status = Status::Computed;
    e_.store_.put_action(r.record, std::move(record));
    return true;
  }

  // Keeps a value that cannot be read back from the disk as long as consumers may need it. Other values are
  // left to the store and its memory budget.
  void keep(int i, const std::string& port, Value value) {
    if (e_.store_.keeps_on_disk()) return;
    const std::lock_guard lock(state(i).mutex);
    state(i).values[port] = std::move(value);
  }

  ComputeRequest request(int i, Work work) {
    ComputeRequest q;
    q.type = node(i).type;
    for (const auto& [port, wires] : node(i).inputs) {
      const bool later = q.type->find_input(port)->one_at_a_time;
      for (const auto& w : wires)
        if (later)
          q.later[port].push_back([this, &w] { return value_of(w, false); });
        else
          q.inputs[port].push_back(value_of(w));
    }
    std::map<std::string, ParameterValue> written;
    for (const auto& [name, p] : node(i).parameters) written[name] = p.value;
    q.parameters = effective_parameters(*q.type, written);
    q.files = state(i).files.paths;
    q.output_folder = options_.output_folder;
    if (q.type->writes_files) q.provenance = provenance(i), q.protected_files = all_input_files();
    q.work = std::move(work);
    q.memory = options_.memory;
    if (options_.keep_intermediates) q.intermediates = Intermediates(e_.store_);
    if (options_.observer) {
      q.watched = [this, i] { return options_.observer->wants_previews(i); };
      q.preview = [this, i](const std::string& port, const Value& v) {
        tell([&](Observer& o) { o.preview(i, port, v); });
      };
    }
    q.save_interrupted = [this, i](const InterruptedWork& work) {
      if (run_is_cancelled()) result(i).saved = save(work, node(i), options_.output_folder);
    };
    return q;
  }

  // Whether the whole run is canceled, not only nodes that an edit made obsolete.
  bool run_is_cancelled() const {
    return (options_.cancel && *options_.cancel) || (options_.cancel_all && *options_.cancel_all);
  }

  // The input files of every node of the graph, needed or not.
  std::vector<fs::path> all_input_files() const {
    std::vector<fs::path> out{graph_.file};
    for (const auto& n : graph_.nodes)
      for (const auto& p : n.type->parameters)
        if (const auto it = n.parameters.find(p.name);
            p.kind == ParameterKind::InputPath && it != n.parameters.end())
          for (const auto& path : expand_glob(std::get<std::string>(it->second.value)))
            for (const auto& file : files_opened(*n.type, path)) out.push_back(file);
    return out;
  }

  // The caller's provenance, plus the action keys of all upstream nodes, the content hashes of their input
  // files, and a graph that reproduces this result.
  std::string provenance(int i) {
    nlohmann::json all =
        options_.provenance.empty() ? nlohmann::json::object() : nlohmann::json::parse(options_.provenance);
    const auto upstream = needed_nodes(graph_, {i});
    all["files"] = nlohmann::json::array();
    for (std::size_t k = 0; k < upstream.size(); ++k) {
      if (!upstream[k]) continue;
      all["keys"][graph_.nodes[k].path] = result_.nodes[k].key.text();
      for (const auto& f : result_.nodes[k].read)
        all["files"].push_back(
            {{"name", fs::path(f.path).filename().string()}, {"content", f.content.text()}});
    }
    all["document"] = write_graph(graph_, upstream, options_.output_folder);
    return json_text(all);
  }

  // `keep`: whether a value that is read from the disk stays in memory.
  Value value_of(const Wire& w, bool keep = true) {
    State& s = state(w.node);
    const NodeResult& r = result(w.node);
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

  void compute_again(int i) {
    State& s = state(i);
    const NodeResult& r = result(i);
    tell([&](Observer& o) { o.started(i); });
    const auto start = std::chrono::steady_clock::now();
    s.files = input_files(node(i), e_.hashes_);
    Inputs inputs;
    for (const auto& [port, wires] : node(i).inputs)
      for (const auto& w : wires) inputs[port].push_back(result(w.node).outputs.at(w.port));
    const auto changed = [&] {
      return placed_error(Error("file-changed",
                                "an input file changed during the run, so a lost cached value cannot be "
                                "recomputed",
                                "run again"),
                          node(i));
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
        throw placed_error(
            Error("not-deterministic", "the recomputed output '" + port + "' differs from its cached record",
                  "the record was removed from the cache: run again"),
            node(i));
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

  static Error placed_error(const Error& e, const GraphNode& node) { return Error(placed(e, node)); }

  Evaluator& e_;
  const Graph& graph_;
  const RunOptions& options_;
  std::vector<State> states_;
  RunResult result_;
  tbb::task_group group_;
  std::optional<Arena> arena_;
  ThreadMark mark_;
  std::mutex observer_mutex_;
};

RunResult Evaluator::run(const Graph& graph, const RunOptions& options) {
  return Run(*this, graph, options).run();
}

Value Evaluator::value(const Graph& graph, const RunResult& result, const Wire& wire,
                       const RunOptions& options) {
  return Run::fetch(*this, graph, result, wire, options);
}

}  // namespace terrazzo
