// The evaluator: runs what the targets need and nothing that was computed before.
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
  double seconds = 0;         // of this run
  double cached_seconds = 0;  // that the cached computation once took
  Hash key;                   // of the computation
  Hash record;                // under which it is recorded
  std::map<std::string, OutputRecord> outputs;
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  std::vector<FileRecord> files;  // written
  std::vector<FileRecord> read;   // that its parameters name
  std::optional<Diagnostic> error;
};

struct RunResult {
  std::vector<NodeResult> nodes;  // as in Graph::nodes
  double seconds = 0;
  std::string trouble;  // what failed beside the nodes, such as the observer; empty where nothing did
  bool failed() const;
  bool cancelled() const;
};

// Told what happens, from any thread, one call at a time.
struct Observer {
  virtual ~Observer() = default;
  virtual void started(int /*node*/) {}
  virtual void progress(int /*node*/, double /*fraction*/, const std::string& /*note*/) {}
  // Once a node. A cached node whose value is lost and asked for later is started again without it.
  virtual void finished(int /*node*/, const NodeResult&) {}
};

struct RunOptions {
  std::vector<int> targets;  // nodes; empty: the graph's sinks
  std::filesystem::path output_folder = "out";
  int threads = 0;  // 0: as many as the machine has
  const std::atomic<bool>* cancel = nullptr;
  const std::deque<std::atomic<bool>>* cancel_node = nullptr;  // one a node: stops that node alone
  Observer* observer = nullptr;
  std::uint64_t memory = 0;  // bytes that one loaded file may take; 0: what the machine has left
  std::string provenance;    // JSON object, handed to nodes that write files
};

class Evaluator {
 public:
  Evaluator(const ValueTypes& types, Store& store, FileHashes& hashes)
      : types_(types), store_(store), hashes_(hashes) {}

  // Several runs may go on at once, from several threads: no key is computed twice at a time.
  RunResult run(const Graph&, const RunOptions&);
  // A value of a finished run; computed again where the store has lost it.
  Value value(const Graph&, const RunResult&, const Wire&, const RunOptions& = {});

  const ValueTypes& types() const { return types_; }
  Store& store() { return store_; }
  FileHashes& hashes() { return hashes_; }

 private:
  friend class Run;
  // True: the key is the caller's until end(). False: somebody is at it, and what `later` makes is called
  // then.
  bool begin(const Hash& key, const std::function<std::function<void()>()>& later);
  void end(const Hash& key);

  const ValueTypes& types_;
  Store& store_;
  FileHashes& hashes_;
  std::mutex mutex_;
  std::unordered_map<Hash, std::vector<std::function<void()>>> busy_;
};

// The nodes that "NODE", "NODE.PORT" or names of outputs mean. Throws Error "unknown-node" / "unknown-port".
std::vector<int> target_nodes(const Graph&, const std::vector<std::string>& targets);

// Nodes that the targets need, themselves included.
std::vector<bool> needed_nodes(const Graph&, const std::vector<int>& targets);

// A node's error with its path and place.
Diagnostic placed(const Error&, const GraphNode&);

}  // namespace terrazzo
