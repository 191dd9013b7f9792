#include "runtime/evaluate.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/compute_node.h"

namespace terrazzo {
namespace fs = std::filesystem;

const char* name_of(Status s) {
  switch (s) {
    case Status::Unneeded:
      return "unneeded";
    case Status::Computed:
      return "computed";
    case Status::Memory:
      return "memory";
    case Status::Disk:
      return "disk";
    case Status::Failed:
      return "failed";
    case Status::Skipped:
      return "skipped";
    case Status::Cancelled:
      return "cancelled";
  }
  return "?";
}

bool RunResult::failed() const {
  for (const auto& n : nodes)
    if (n.status == Status::Failed) return true;
  return false;
}

bool RunResult::cancelled() const {
  for (const auto& n : nodes)
    if (n.status == Status::Cancelled) return true;
  return false;
}

std::vector<bool> needed_nodes(const Graph& graph, const std::vector<int>& targets) {
  std::vector<bool> needed(graph.nodes.size(), false);
  for (const int t : targets) needed[static_cast<std::size_t>(t)] = true;
  for (std::size_t i = graph.nodes.size(); i-- > 0;)  // consumers stand after their sources
    if (needed[i])
      for (const auto& [port, wires] : graph.nodes[i].inputs)
        for (const auto& w : wires) needed[static_cast<std::size_t>(w.node)] = true;
  return needed;
}

InputFiles input_files(const GraphNode& node, FileHashes& hashes) {
  InputFiles out;
  for (const auto& p : node.type->parameters) {
    const auto written = node.parameters.find(p.name);
    if (p.kind != ParameterKind::InputPath || written == node.parameters.end()) continue;
    const std::string& pattern = std::get<std::string>(written->second.value);
    auto& paths = out.paths[p.name] = expand_glob(pattern);
    if (paths.empty())
      throw Error("no-file", "there is no file '" + pattern + "'",
                  "paths in a graph are relative to the graph file")
          .parameter(p.name);
    for (const auto& path : paths) {
      const auto hash = hashes.hash(path);
      if (!hash) throw Error("unreadable-file", "cannot read '" + path.string() + "'").parameter(p.name);
      // Readers choose the format by extension, so it belongs to the content.
      out.hashes[p.name].push_back(hash_of(hash->text() + path.extension().string()));
    }
  }
  return out;
}

Hash action_key(const GraphNode& node, const std::map<std::string, std::vector<Hash>>& files,
                const std::map<std::string, std::vector<OutputRecord>>& inputs) {
  HashWriter w;
  w.text(node.type->name);
  w.pod(node.type->version);
  for (const auto& p : node.type->parameters) {
    w.text(p.name);
    if (const auto f = files.find(p.name); f != files.end()) {
      for (const auto& h : f->second) w.text(h.text());
      continue;
    }
    const auto it = node.parameters.find(p.name);
    w.text(it != node.parameters.end() ? canonical(it->second.value) : p.value ? canonical(*p.value) : "");
  }
  for (const auto& port : node.type->inputs) {
    w.text(port.name);
    const auto it = inputs.find(port.name);
    w.pod<std::uint64_t>(it == inputs.end() ? 0 : it->second.size());
    if (it != inputs.end())
      for (const auto& r : it->second) w.text(r.content.text());
  }
  return w.hash();
}

namespace {

Diagnostic placed(const Error& e, const GraphNode& node) {
  Diagnostic d = e.diagnostic();
  d.node = node.path;
  if (d.place.file.empty()) {
    const auto it = node.parameters.find(d.parameter);
    d.place = it != node.parameters.end() ? it->second.place : node.place;
  }
  return d;
}

}  // namespace

// One run: every node a task that starts when its sources are done.
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
    const int threads =
        options_.threads > 0 ? options_.threads : static_cast<int>(std::thread::hardware_concurrency());
    // More threads than cores are allowed where somebody asks for them.
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(std::max(threads, 1)));
    tbb::task_arena arena(std::max(threads, 1));
    arena.execute([&] {
      for (const int i : ready) group_.run([this, i] { visit(i); });
      group_.wait();
    });
    result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return std::move(result_);
  }

  // For Evaluator::value: a finished run's value.
  static Value fetch(Evaluator& e, const Graph& graph, const RunResult& result, const Wire& wire) {
    RunOptions options;
    Run again(e, graph, options);
    again.result_ = result;
    return again.value_of(wire);
  }

 private:
  struct State {
    std::atomic<int> waiting{0};
    std::atomic<int> users{0};  // consumers that may still ask for a value
    std::vector<int> consumers;
    std::map<std::string, Value> values;  // kept while anybody may ask
    std::mutex mutex;                     // of values and of computing again
    InputFiles files;
  };

  NodeResult& result(int i) { return result_.nodes[static_cast<std::size_t>(i)]; }
  State& state(int i) { return states_[static_cast<std::size_t>(i)]; }
  const GraphNode& node(int i) const { return graph_.nodes[static_cast<std::size_t>(i)]; }

  void visit(int i) {
    try {
      evaluate(i);
    } catch (const Cancelled&) {
      result(i).status = Status::Cancelled;
    } catch (const Error& error) {
      result(i).status = Status::Failed;
      result(i).error = placed(error, node(i));
    }
    if (options_.observer) {
      const std::lock_guard lock(observer_mutex_);
      options_.observer->finished(i, result(i));
    }
    for (const auto& [port, wires] : node(i).inputs)
      for (const auto& w : wires)
        if (--state(w.node).users == 0) {
          const std::lock_guard lock(state(w.node).mutex);
          state(w.node).values.clear();
        }
    for (const int c : state(i).consumers)
      if (--state(c).waiting == 0) group_.run([this, c] { visit(c); });
  }

  void evaluate(int i) {
    NodeResult& r = result(i);
    if (options_.cancel && *options_.cancel) throw Cancelled();
    std::map<std::string, std::vector<OutputRecord>> inputs;
    for (const auto& [port, wires] : node(i).inputs)
      for (const auto& w : wires) {
        const NodeResult& source = result(w.node);
        if (source.status == Status::Cancelled) throw Cancelled();
        if (source.status == Status::Failed || source.status == Status::Skipped) {
          r.status = Status::Skipped;
          return;
        }
        inputs[port].push_back(source.outputs.at(w.port));
      }
    state(i).files = input_files(node(i), e_.hashes_);
    r.key = action_key(node(i), state(i).files.hashes, inputs);
    if (use_cached(i)) return;
    // Two nodes of one graph can ask for the same key: the second waits for the first and takes its result.
    const std::shared_ptr<std::mutex> one = one_at_a_time(r.key);
    tbb::this_task_arena::isolate([&] {
      const std::lock_guard lock(*one);
      if (!use_cached(i)) compute(i);
    });
  }

  bool use_cached(int i) {
    NodeResult& r = result(i);
    Tier tier;
    const auto record = e_.store_.find_action(r.key, tier);
    if (!record) return false;
    // Files count as cached only while they stand as they were written, never because something has that
    // name.
    for (const auto& f : record->files) {
      const auto now = e_.hashes_.hash(options_.output_folder / f.path);
      if (!now || *now != f.content) return false;
    }
    for (const auto& [port, o] : record->outputs)
      if (!e_.store_.has_value(o)) return false;
    r.status = tier == Tier::Memory ? Status::Memory : Status::Disk;
    r.outputs = record->outputs, r.metrics = record->metrics, r.warnings = record->warnings,
    r.files = record->files;
    r.cached_seconds = record->seconds;
    return true;
  }

  void compute(int i) {
    NodeResult& r = result(i);
    if (options_.observer) {
      const std::lock_guard lock(observer_mutex_);
      options_.observer->started(i);
    }
    const auto start = std::chrono::steady_clock::now();
    const Work::Report report = [this, i](double fraction, const std::string& note) {
      if (!options_.observer) return;
      const std::lock_guard lock(observer_mutex_);
      options_.observer->progress(i, fraction, note);
    };
    ComputeResult computed = compute_node(request(i, Work(options_.cancel, &report)));
    ActionRecord record;
    for (auto& [port, value] : computed.outputs) {
      record.outputs[port] = e_.store_.put_value(value);
      const std::lock_guard lock(state(i).mutex);
      state(i).values[port] = std::move(value);
    }
    for (const auto& f : computed.files) {
      const auto hash = e_.hashes_.hash(options_.output_folder / f);
      if (!hash) throw Error("write-failed", "the file '" + f + "' is gone right after it was written");
      record.files.push_back({f, *hash});
    }
    record.metrics = std::move(computed.metrics), record.warnings = std::move(computed.warnings);
    r.seconds = record.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    r.outputs = record.outputs, r.metrics = record.metrics, r.warnings = record.warnings,
    r.files = record.files;
    r.status = Status::Computed;
    e_.store_.put_action(r.key, record);
  }

  ComputeRequest request(int i, Work work) {
    ComputeRequest q;
    q.type = node(i).type;
    for (const auto& [port, wires] : node(i).inputs)
      for (const auto& w : wires) q.inputs[port].push_back(value_of(w));
    std::map<std::string, ParameterValue> written;
    for (const auto& [name, p] : node(i).parameters) written[name] = p.value;
    q.parameters = effective_parameters(*q.type, written);
    q.files = state(i).files.paths;
    q.output_folder = options_.output_folder;
    if (q.type->writes_files) q.provenance = provenance(i);
    q.work = std::move(work);
    return q;
  }

  // What the caller says of the graph, and the keys of all nodes upstream.
  std::string provenance(int i) {
    nlohmann::json all =
        options_.provenance.empty() ? nlohmann::json::object() : nlohmann::json::parse(options_.provenance);
    const auto upstream = needed_nodes(graph_, {i});
    for (std::size_t k = 0; k < upstream.size(); ++k)
      if (upstream[k]) all["keys"][graph_.nodes[k].path] = result_.nodes[k].key.text();
    return all.dump();
  }

  Value value_of(const Wire& w) {
    State& s = state(w.node);
    {
      const std::lock_guard lock(s.mutex);
      if (const auto it = s.values.find(w.port); it != s.values.end()) return it->second;
    }
    if (Value v = e_.store_.get_value(result(w.node).outputs.at(w.port))) return v;
    // The record is known but the value is lost or damaged: compute the source again. Isolated, so that this
    // thread cannot meanwhile take a task that waits for the same source.
    Value v;
    tbb::this_task_arena::isolate([&] {
      const std::lock_guard lock(s.mutex);
      if (const auto it = s.values.find(w.port); it != s.values.end()) {
        v = it->second;
        return;
      }
      s.files = input_files(node(w.node), e_.hashes_);
      ComputeResult again = compute_node(request(w.node, Work(options_.cancel, nullptr)));
      for (auto& [port, value] : again.outputs) {
        e_.store_.put_value(value);
        s.values[port] = std::move(value);
      }
      v = s.values.at(w.port);
    });
    return v;
  }

  std::shared_ptr<std::mutex> one_at_a_time(const Hash& key) {
    const std::lock_guard lock(keys_mutex_);
    auto& m = keys_[key];
    if (!m) m = std::make_shared<std::mutex>();
    return m;
  }

  Evaluator& e_;
  const Graph& graph_;
  const RunOptions& options_;
  std::vector<State> states_;
  RunResult result_;
  tbb::task_group group_;
  std::mutex observer_mutex_, keys_mutex_;
  std::map<Hash, std::shared_ptr<std::mutex>> keys_;
};

RunResult Evaluator::run(const Graph& graph, const RunOptions& options) {
  return Run(*this, graph, options).run();
}

Value Evaluator::value(const Graph& graph, const RunResult& result, const Wire& wire) {
  return Run::fetch(*this, graph, result, wire);
}

}  // namespace terrazzo
