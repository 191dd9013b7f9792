// Store: what was computed before. Two tables, action key → record and content hash → value, in memory and on
// disk.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <unordered_map>

#include "runtime/action_record.h"
#include "runtime/value.h"

namespace terrazzo {

enum class Tier { None, Memory, Disk };

class Store {
 public:
  static constexpr std::uint64_t default_memory = 2ull << 30;

  // Without a folder everything stays in memory. So it does, with trouble() saying why, if the folder is no
  // cache and cannot become one. `memory`: bytes of values kept in memory beyond those in use.
  Store(const ValueTypes& types, std::filesystem::path folder, std::uint64_t memory = default_memory);

  // Null where there is none.
  std::shared_ptr<const ActionRecord> find_action(const Hash& key, Tier& from);
  void put_action(const Hash& key, std::shared_ptr<const ActionRecord>);
  // Forgets a record that turned out wrong.
  void drop_action(const Hash& key);

  // Hashes the value and keeps it. `seconds`: what computing it took; the least seconds per byte leave memory
  // first.
  OutputRecord put_value(const Value&, double seconds = 0);
  // An empty Value where it is gone or damaged (damaged files are removed).
  Value get_value(const OutputRecord&, double seconds = 0);
  bool has_value(const OutputRecord&);

  const std::filesystem::path& folder() const { return folder_; }
  // Values written can be read back later: there is a folder and nothing went wrong with it.
  bool keeps_on_disk() const { return !folder_.empty() && trouble().empty(); }
  // The first thing that went wrong with the disk, or "": results were not kept, the run goes on.
  std::string trouble() const;
  // Bytes written to the disk by this store.
  std::uint64_t written() const { return written_; }

 private:
  void keep_in_memory(const Hash&, const Value&, std::uint64_t bytes, double seconds);
  void note_trouble(const std::string&);

  const ValueTypes& types_;
  std::filesystem::path folder_;
  std::uint64_t memory_, used_ = 0;
  std::atomic<std::uint64_t> written_{0};
  mutable std::mutex mutex_;
  // Greedy dual: a value's worth is seconds per byte above the worth of what left last, renewed at each use.
  // So both what is cheap and what is long unused leave first.
  struct Kept {
    Value value;
    std::uint64_t bytes;
    double per_byte, worth;
  };
  double left_worth_ = 0;
  std::unordered_map<Hash, Kept> values_;
  std::set<std::pair<double, Hash>> by_worth_;
  std::unordered_map<Hash, std::shared_ptr<const ActionRecord>> actions_;
  std::string trouble_;
};

// A record file's content: null where it is damaged or foreign.
std::shared_ptr<const ActionRecord> parse_action(const std::string& text);

}  // namespace terrazzo
