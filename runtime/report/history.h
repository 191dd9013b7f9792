// History: what each node of each graph was last computed from, so that `explain` can report what changed.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/evaluate.h"

namespace terrazzo {

struct HistoryEntry {
  std::string key;  // record_key()
  std::string type;
  int version = 0;
  std::map<std::string, std::string> parameters;           // as written in a graph file
  std::map<std::string, std::vector<std::string>> files;   // content hashes by parameter
  std::map<std::string, std::vector<std::string>> inputs;  // content hashes by port
};

class History {
 public:
  explicit History(std::filesystem::path cache_folder)  // empty: nothing is stored
      : folder_(std::move(cache_folder)) {}
  std::optional<HistoryEntry> find(const Graph&, const GraphNode&) const;
  // Stores the entries of a finished run. Does not rewrite unchanged entries.
  void record(const Graph&, const RunResult&, FileHashes&) const;

 private:
  std::filesystem::path folder_;
};

HistoryEntry history_entry(const GraphNode&, const std::vector<NodeResult>&, FileHashes&, const Hash& key);

}  // namespace terrazzo
