// The evaluator: computes the nodes that the targets need, except those with cached results.
#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "graph/graph.h"
#include "runtime/cache/file_hashes.h"
#include "runtime/cache/store.h"
#include "runtime/run_result.h"

namespace terrazzo {

// Receives start, progress and completion events of nodes, from any thread, one call at a time.
struct Observer {
  virtual ~Observer() = default;
  virtual void started(int /*node*/) {}
  virtual void progress(int /*node*/, double /*fraction*/, const std::string& /*note*/) {}
  // Whether preliminary values of a node are wanted now. Called from any thread, at any time.
  virtual bool wants_previews(int /*node*/) { return false; }
  // A preliminary value of an output. The node's result follows, unless it is canceled or fails.
  virtual void preview(int /*node*/, const std::string& /*port*/, const Value&) {}
  // Called once per node. If a cached node's value is lost and needed later, the node starts without another
  // call to finished().
  virtual void finished(int /*node*/, const NodeResult&) {}
};

struct RunOptions {
  std::vector<int> targets;  // node indices; empty: the graph's sinks
  std::filesystem::path output_folder = "out";
  int threads = 0;  // 0: one per CPU core
  const std::atomic<bool>* cancel = nullptr;
  const std::deque<std::atomic<bool>>* cancel_node = nullptr;  // one per node: stops only that node
  // True once `cancel_node` was set for all nodes because the whole run is canceled. Nodes then save what
  // they have reached, as they do after `cancel`. Not set if an edit makes single nodes obsolete.
  const std::atomic<bool>* cancel_all = nullptr;
  Observer* observer = nullptr;
  std::uint64_t memory = 0;  // bytes that loading one file may take; 0: all available memory
  // Keep intermediate results in the store's memory. For graphs that are evaluated again and again.
  bool keep_intermediates = false;
  std::string provenance;  // JSON object for nodes that write files
};

class Evaluator {
 public:
  Evaluator(const ValueTypes& types, Store& store, FileHashes& hashes)
      : types_(types), store_(store), hashes_(hashes) {}

  // Runs may execute concurrently, from several threads. A key is never computed by two runs at the same
  // time.
  RunResult run(const Graph&, const RunOptions&);
  // Returns a value of a finished run. Recomputes it if the store has lost it.
  Value value(const Graph&, const RunResult&, const Wire&, const RunOptions& = {});

  const ValueTypes& types() const { return types_; }
  Store& store() { return store_; }
  FileHashes& hashes() { return hashes_; }

 private:
  friend class Run;
  // True: the caller owns the key until end(). False: the key is being computed elsewhere; the function that
  // `later` returns is called when that ends.
  bool begin(const Hash& key, const std::function<std::function<void()>()>& later);
  void end(const Hash& key);

  const ValueTypes& types_;
  Store& store_;
  FileHashes& hashes_;
  std::mutex mutex_;
  std::unordered_map<Hash, std::vector<std::function<void()>>> busy_;
};

}  // namespace terrazzo
