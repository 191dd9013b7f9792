// Store: what was computed before. Two tables, action key → record and content hash → value, in memory and on
// disk.
#pragma once

#include <filesystem>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/hash.h"
#include "runtime/value.h"

namespace terrazzo {

struct OutputRecord {
  std::string type;
  Hash content;  // of type and encoded value
  std::uint64_t bytes = 0;
  bool operator==(const OutputRecord&) const = default;
};

struct FileRecord {
  std::string path;  // relative to the output folder
  Hash content;
};

// All that is known of one computation.
struct ActionRecord {
  std::map<std::string, OutputRecord> outputs;  // by port
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  std::vector<FileRecord> files;
  double seconds = 0;
};

enum class Tier { None, Memory, Disk };

class Store {
 public:
  // Without a folder everything stays in memory. `budget`: bytes of values kept in memory beyond those in
  // use.
  Store(const ValueTypes& types, std::filesystem::path folder, std::uint64_t budget = 2ull << 30);

  std::optional<ActionRecord> find_action(const Hash& key, Tier& from);
  void put_action(const Hash& key, const ActionRecord&);

  // Hashes the value and keeps it. The record names it from now on.
  OutputRecord put_value(const Value&);
  // An empty Value where it is gone or damaged (damaged files are removed).
  Value get_value(const OutputRecord&);
  bool has_value(const OutputRecord&);

  const std::filesystem::path& folder() const { return folder_; }
  // The first thing that went wrong with the disk, or "": results were not kept, the run goes on.
  std::string trouble() const;

 private:
  std::filesystem::path action_path(const Hash&) const;
  std::filesystem::path value_path(const Hash&) const;
  void keep_in_memory(const Hash&, const Value&, std::uint64_t bytes);
  void note_trouble(const std::string&);

  const ValueTypes& types_;
  std::filesystem::path folder_;
  std::uint64_t budget_, used_ = 0;
  mutable std::mutex mutex_;
  struct Kept {
    Value value;
    std::uint64_t bytes;
    std::list<Hash>::iterator age;
  };
  std::unordered_map<Hash, Kept> values_;
  std::list<Hash> ages_;  // least recently used first
  std::unordered_map<Hash, ActionRecord> actions_;
  std::string trouble_;
};

}  // namespace terrazzo
