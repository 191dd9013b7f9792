// The evaluator: runs what the targets need and nothing that was computed before.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/files.h"
#include "runtime/store.h"

namespace terrazzo {

enum class Status { Unneeded, Computed, Memory, Disk, Failed, Skipped, Cancelled };
const char* name_of(Status);

struct NodeResult {
  Status status = Status::Unneeded;
  double seconds = 0;         // of this run
  double cached_seconds = 0;  // that the cached computation once took
  Hash key;
  std::map<std::string, OutputRecord> outputs;
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  std::vector<FileRecord> files;
  std::optional<Diagnostic> error;
};

struct RunResult {
  std::vector<NodeResult> nodes;  // as in Graph::nodes
  double seconds = 0;
  bool failed() const;
  bool cancelled() const;
};

// Told what happens, from any thread, one call at a time.
struct Observer {
  virtual ~Observer() = default;
  virtual void started(int /*node*/) {}
  virtual void progress(int /*node*/, double /*fraction*/, const std::string& /*note*/) {}
  virtual void finished(int /*node*/, const NodeResult&) {}
};

struct RunOptions {
  std::vector<int> targets;  // nodes; empty: the graph's sinks
  std::filesystem::path output_folder = "out";
  int threads = 0;  // 0: as many as the machine has
  const std::atomic<bool>* cancel = nullptr;
  Observer* observer = nullptr;
  std::string provenance;  // JSON, handed to nodes that write files
};

// The key of a node's computation: type, version, canonical parameters, content of files and inputs. Nothing
// else.
Hash action_key(const GraphNode&, const std::map<std::string, std::vector<Hash>>& files,
                const std::map<std::string, std::vector<OutputRecord>>& inputs);

// A path parameter's files and their content. Throws Error "no-file" with the parameter.
struct InputFiles {
  std::map<std::string, std::vector<std::filesystem::path>> paths;
  std::map<std::string, std::vector<Hash>> hashes;  // of content and extension
};
InputFiles input_files(const GraphNode&, FileHashes&);

class Evaluator {
 public:
  Evaluator(const ValueTypes& types, Store& store, FileHashes& hashes)
      : types_(types), store_(store), hashes_(hashes) {}

  RunResult run(const Graph&, const RunOptions&);
  // A value of a finished run; computed again where the store has lost it.
  Value value(const Graph&, const RunResult&, const Wire&);

 private:
  friend class Run;
  const ValueTypes& types_;
  Store& store_;
  FileHashes& hashes_;
};

// Nodes that the targets need, themselves included.
std::vector<bool> needed_nodes(const Graph&, const std::vector<int>& targets);

}  // namespace terrazzo
