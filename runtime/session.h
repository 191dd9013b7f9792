// Session: a graph open for work. What the command line drives, and an editor or any other program may.
//
//   Session session(registry, types, {.cache_folder = "cache"});
//   session.open("terrazzo.yaml");
//   auto evaluation = session.evaluate({"pack"});   // returns at once
//   session.set("pack.seed", "2");                  // stops what this makes obsolete, and nothing else
//   Value v = session.value("pack.particles");      // waits
#pragma once

#include <condition_variable>
#include <memory>
#include <thread>

#include "graph/registry.h"
#include "runtime/evaluate.h"
#include "runtime/history.h"

namespace terrazzo {

struct SessionOptions {
  std::filesystem::path cache_folder = {};  // empty: results live in memory alone
  std::uint64_t memory = Store::default_memory;
  std::uint64_t file_memory = 0;  // bytes that one loaded file may take; 0: what the machine has left
  std::filesystem::path output_folder = "out";
  int threads = 0;                            // 0: as many as the machine has
  const std::atomic<bool>* cancel = nullptr;  // stops every evaluation
};

// One evaluation, going on or done. The graph it works on stays as it was when it began.
class Evaluation {
 public:
  ~Evaluation();  // cancels and waits
  const Graph& graph() const { return *graph_; }
  bool done() const;
  // Throws only where the evaluation itself broke down; what failed in nodes is in the result.
  const RunResult& wait();
  void cancel();

 private:
  friend class Session;
  Evaluation() = default;
  std::shared_ptr<const Graph> graph_;
  RunOptions options_;
  std::atomic<bool> cancel_{false};
  std::deque<std::atomic<bool>> cancel_node_;
  mutable std::mutex mutex_;
  std::condition_variable finished_;
  bool done_ = false;
  std::exception_ptr failure_;  // of the evaluation itself, not of a node
  RunResult result_;
  std::thread thread_;
};

class Session {
 public:
  Session(const Registry&, const ValueTypes&, SessionOptions = {});
  ~Session();

  // Reads a graph; what it finds wrong is returned. With errors the graph that was open stays.
  Diagnostics open(const std::filesystem::path& file, Overrides = {});
  Diagnostics open_text(std::string text, const std::filesystem::path& file, Overrides = {});

  // Edits: "pack.seed" = "2", a parameter of the graph, an input. With errors nothing changes; else
  // evaluations stop at the nodes that the edit makes obsolete, and go on with all others.
  Diagnostics set(const std::string& node_parameter, const std::string& value);
  Diagnostics set_parameter(const std::string& name, const std::string& value);
  Diagnostics connect(const std::string& node_input, const std::vector<std::string>& outputs);

  // The graph as it is now; the pointer keeps it.
  std::shared_ptr<const Graph> graph() const { return graph_; }
  const Overrides& overrides() const { return overrides_; }

  // Starts evaluating "NODE", "NODE.PORT" or names of outputs; none: every sink. The observer must outlive
  // the evaluation. Throws Error "unknown-node" / "unknown-port".
  std::shared_ptr<Evaluation> evaluate(const std::vector<std::string>& targets = {}, Observer* = nullptr);
  // Evaluates one output and waits. Throws the node's Error, or Cancelled.
  Value value(const std::string& output);

  // What a node took when it was last computed in this cache, in seconds; 0 where that is not known.
  double known_seconds(const GraphNode&);

  Evaluator& evaluator() { return evaluator_; }
  const History& history() const { return history_; }
  const SessionOptions& options() const { return options_; }

 private:
  Diagnostics load(Overrides);

  const Registry& registry_;
  SessionOptions options_;
  Store store_;
  FileHashes hashes_;
  History history_;
  Evaluator evaluator_;
  std::string text_;
  std::filesystem::path file_;
  Overrides overrides_;
  std::shared_ptr<const Graph> graph_ = std::make_shared<Graph>();
  std::vector<std::weak_ptr<Evaluation>> evaluations_;
};

}  // namespace terrazzo
