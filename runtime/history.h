// History: what each node of each graph was last computed from, so that `explain` can tell what changed.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/evaluate.h"

namespace terrazzo {

struct HistoryEntry {
  std::string key;  // of its record
  std::string type;
  int version = 0;
  std::map<std::string, std::string> parameters;           // as a person writes them
  std::map<std::string, std::vector<std::string>> files;   // content
  std::map<std::string, std::vector<std::string>> inputs;  // content
};

class History {
 public:
  explicit History(std::filesystem::path cache_folder)  // empty: remembers nothing
      : folder_(std::move(cache_folder)) {}
  std::optional<HistoryEntry> find(const Graph&, const GraphNode&) const;
  // Keeps what a finished run knows; entries that did not change are not written again.
  void record(const Graph&, const RunResult&, FileHashes&) const;

 private:
  std::filesystem::path folder_;
};

HistoryEntry history_entry(const GraphNode&, const std::vector<NodeResult>&, FileHashes&, const Hash& key);

}  // namespace terrazzo
