// What a run found about each node, and which nodes a run needs.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/cache/action_key.h"
#include "runtime/cache/store.h"

namespace terrazzo {

enum class Status { Unneeded, Computed, Memory, Disk, Failed, Skipped, Cancelled };
const char* name_of(Status);

// What a canceled node saved with Context::save_interrupted.
struct SavedWork {
  std::filesystem::path file;  // below the output folder; empty if it could not be written
  Diagnostic message;          // for the user: a note with the file's name, or a warning with the reason
};

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
  bool tolerated = false;          // failed or skipped, which is no failure of the run: GraphNode::may_fail
  std::optional<SavedWork> saved;  // of a canceled node; not a result, so it is not cached
};

struct RunResult {
  std::vector<NodeResult> nodes;  // as in Graph::nodes
  double seconds = 0;
  std::string trouble;          // a failure outside the nodes, such as in the observer; "" if there was none
  bool without_result = false;  // nothing that was asked for has a result, so that no failure is tolerated
  bool failed() const { return !errors().empty(); }
  Diagnostics errors() const;  // of the nodes whose failure is one of the run
  bool cancelled() const;
};

// The nodes for targets given as "NODE", "NODE.PORT" or graph outputs. Throws Error "unknown-node" or
// "unknown-port".
std::vector<int> target_nodes(const Graph&, const std::vector<std::string>& targets);

// Marks the nodes that the targets need, including the targets.
std::vector<bool> needed_nodes(const Graph&, const std::vector<int>& targets);

// Whether `reader` runs as if this wire of it was not there, because the source is outside the part of the
// graph that `reader` belongs to, and may fail, and did.
bool is_left_out(const Graph&, const RunResult&, const GraphNode& reader, const Wire&);

// Marks the node and those whose results it used.
std::vector<bool> used_nodes(const Graph&, const RunResult&, int node);

// The diagnostic of a node's error, with the node's path and the place filled in.
Diagnostic placed(const Error&, const GraphNode&);

}  // namespace terrazzo
