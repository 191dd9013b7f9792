// Session: an open graph that can be edited and evaluated. Used by the command line; meant for editors and
// other programs too.
//
//   Session session(registry, types, {.cache_folder = "cache"});
//   session.open("terrazzo.yaml");
//   auto evaluation = session.evaluate({"pack"});   // returns immediately
//   session.set("pack.seed", "2");                  // cancels only the nodes that this makes stale
//   Value v = session.value("pack.particles");      // waits
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <thread>

#include "graph/document/raw_document.h"
#include "graph/registry.h"
#include "runtime/evaluate.h"
#include "runtime/report/history.h"

namespace terrazzo {

struct SessionOptions {
  std::filesystem::path cache_folder = {};  // empty: results are kept only in memory
  std::uint64_t memory = Store::kDefaultMemory;
  std::uint64_t file_memory = 0;  // bytes that loading one file may take; 0: all available memory
  std::filesystem::path output_folder = "out";
  int threads = 0;                            // 0: one per CPU core
  bool keep_intermediates = false;            // see RunOptions; for sessions that evaluate again and again
  const std::atomic<bool>* cancel = nullptr;  // cancels all evaluations
};

// A running or finished evaluation. It uses the graph as it was when the evaluation started.
class Evaluation {
 public:
  ~Evaluation();  // cancels and waits
  const Graph& graph() const { return *graph_; }
  bool done() const;
  // Waits at most this long. True if it is done.
  bool wait_for(std::chrono::milliseconds);
  // Waits for the result. Throws only if the evaluation itself failed; errors of nodes are in the result.
  const RunResult& wait();
  // Nodes that support it save what they have reached: NodeResult::saved.
  void cancel();
  // Cancels one node, and with it the nodes downstream.
  void cancel_node(int node) { cancel_node_.at(static_cast<std::size_t>(node)) = true; }

 private:
  friend class Session;
  Evaluation() = default;
  std::shared_ptr<const Graph> graph_;
  RunOptions options_;
  std::atomic<bool> cancel_{false};
  std::deque<std::atomic<bool>> cancel_node_;
  mutable std::mutex mutex_;
  std::condition_variable finished_;
  bool done_ = false, follows_edits_ = true;
  std::exception_ptr failure_;  // failure of the evaluation itself, not of a node
  RunResult result_;
  std::thread thread_;
};

class Session {
 public:
  Session(const Registry&, const ValueTypes&, SessionOptions = {});
  ~Session();

  // Loads a graph, or that of a bundle, and returns all messages. If there are errors, the previous graph
  // stays open.
  Diagnostics open(const std::filesystem::path& file, Overrides = {});
  Diagnostics open_text(std::string text, const std::filesystem::path& file, Overrides = {});
  // The same for a document that was made or changed in memory. Like an edit, it cancels the nodes of running
  // evaluations that it makes stale.
  Diagnostics open_document(RawDocument, Overrides = {});
  // The same for what read_document() made of a text, and the messages that it reported.
  Diagnostics open_read(RawDocument, Diagnostics, Overrides = {});

  // Edits: a node's parameter ("pack.seed" = "2"), a graph parameter, an input. If there are errors, nothing
  // changes. Otherwise running evaluations cancel the nodes that the edit makes stale and continue with all
  // others.
  Diagnostics set(const std::string& node_parameter, const std::string& value);
  Diagnostics set_parameter(const std::string& name, const std::string& value);
  Diagnostics connect(const std::string& node_input, const std::vector<std::string>& outputs);

  // The current graph. Edits replace the graph, so the pointer stays valid and its graph unchanged.
  std::shared_ptr<const Graph> graph() const { return graph_; }
  const Overrides& overrides() const { return overrides_; }

  // Starts evaluating targets given as "NODE", "NODE.PORT" or graph outputs; without targets, all sinks. The
  // observer must outlive the evaluation. Throws Error "unknown-node" or "unknown-port".
  std::shared_ptr<Evaluation> evaluate(const std::vector<std::string>& targets = {}, Observer* = nullptr);
  // The same with this many threads (0: as in the options). Later edits do not cancel any of it.
  std::shared_ptr<Evaluation> evaluate_apart(const std::vector<std::string>& targets, Observer*, int threads);
  // Evaluates one output and waits. Throws the node's Error, or Cancelled.
  Value value(const std::string& output);

  // The time in seconds of the node's last computation in this cache; 0 if unknown.
  double known_seconds(const GraphNode&);

  Evaluator& evaluator() { return evaluator_; }
  const History& history() const { return history_; }
  const SessionOptions& options() const { return options_; }
  // Of later evaluations.
  void set_output_folder(std::filesystem::path folder) { options_.output_folder = std::move(folder); }

 private:
  Diagnostics load(Overrides);
  std::shared_ptr<Evaluation> start(const std::vector<std::string>& targets, Observer*, int threads,
                                    bool follows_edits);

  const Registry& registry_;
  SessionOptions options_;
  Store store_;
  FileHashes hashes_;
  History history_;
  Evaluator evaluator_;
  RawDocument document_;
  Overrides overrides_;
  std::shared_ptr<const Graph> graph_ = std::make_shared<Graph>();
  std::vector<std::weak_ptr<Evaluation>> evaluations_;
};

}  // namespace terrazzo
