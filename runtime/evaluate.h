// The evaluator: computes the nodes that the targets need, except those with cached results.
#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "graph/graph.h"
#include "runtime/action_key.h"
#include "runtime/file_hashes.h"
#include "runtime/store.h"

namespace terrazzo {

enum class Status { Unneeded, Computed, Memory, Disk, Failed, Skipped, Cancelled };
const char* name_of(Status);

struct NodeResult {
  Status status = Status::Unneeded;
  double seconds = 0;         // computing time in this run
  double cached_seconds = 0;  // computing time of the cached result
  Hash key;                   // action_key()
  Hash record;                // record_key()
  std::map<std::string, OutputRecord> outputs;
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  std::vector<FileRecord> files;  // files written
  std::vector<FileRecord> read;   // input files, companions included
  std::optional<Diagnostic> error;
};

struct RunResult {
  std::vector<NodeResult> nodes;  // as in Graph::nodes
  double seconds = 0;
  std::string trouble;  // a failure outside the nodes, such as in the observer; "" if there was none
  bool failed() const;
  bool cancelled() const;
};

// Receives start, progress and completion events of nodes, from any thread, one call at a time.
struct Observer {
  virtual ~Observer() = default;
  virtual void started(int /*node*/) {}
  virtual void progress(int /*node*/, double /*fraction*/, const std::string& /*note*/) {}
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
  Observer* observer = nullptr;
  std::uint64_t memory = 0;  // bytes that loading one file may take; 0: all available memory
  std::string provenance;    // JSON object for nodes that write files
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

// The nodes for targets given as "NODE", "NODE.PORT" or graph outputs. Throws Error "unknown-node" or
// "unknown-port".
std::vector<int> target_nodes(const Graph&, const std::vector<std::string>& targets);

// Marks the nodes that the targets need, including the targets.
std::vector<bool> needed_nodes(const Graph&, const std::vector<int>& targets);

// The diagnostic of a node's error, with the node's path and the place filled in.
Diagnostic placed(const Error&, const GraphNode&);

}  // namespace terrazzo
