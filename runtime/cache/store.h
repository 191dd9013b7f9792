// Store: cached results. It has two tables, action key → record and content hash → value, both in memory and
// on disk.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <unordered_map>

#include "runtime/cache/action_record.h"
#include "runtime/value.h"

namespace terrazzo {

class TemporaryFile;  // runtime/files.h

enum class Tier { None, Memory, Disk };

// Computations that another process with the same cache folder finished in the meantime.
struct ComputedTwice {
  std::uint64_t count = 0;
  double seconds = 0;           // computing time of these computations in this process
  std::uint64_t differing = 0;  // those whose outputs differ from the other process's outputs
};

class Store {
 public:
  static constexpr std::uint64_t kDefaultMemory = 2ull << 30;

  // Without a folder, results are kept only in memory. The same happens if the folder is not usable as a
  // cache; trouble() then gives the reason. `memory`: bytes of values to keep in memory in addition to those
  // in use.
  Store(const ValueTypes& types, std::filesystem::path folder, std::uint64_t memory = kDefaultMemory);
  ~Store();  // calls add_usage()

  // Null if there is no record.
  std::shared_ptr<const ActionRecord> find_action(const Hash& key, Tier& from);
  // If another process has stored a record for the key since find_action() looked for it, that record stays
  // on disk and computed_twice() counts the computation.
  void put_action(const Hash& key, std::shared_ptr<const ActionRecord>);
  // Removes a record that proved to be wrong.
  void drop_action(const Hash& key);

  // Hashes and stores the value. `seconds`: its computing time. Values with the fewest seconds per byte are
  // evicted from memory first. A small value is on disk only once put_action() stored the record that
  // contains the result.
  OutputRecord put_value(const Value&, double seconds = 0);
  // Returns an empty Value if it is gone or damaged. Removes damaged files. `keep`: whether a value that is
  // read from the disk stays in memory.
  Value get_value(const OutputRecord&, double seconds = 0, bool keep = true);
  bool has_value(const OutputRecord&);

  // Intermediate results (runtime/intermediates.h): in memory only, evicted like values.
  std::shared_ptr<const void> find_kept(const Hash& key);
  void keep(const Hash& key, std::shared_ptr<const void>, std::uint64_t bytes, double seconds);

  const std::filesystem::path& folder() const { return folder_; }
  // Whether values can be read back from the disk later: there is a folder, and no write failed.
  bool keeps_on_disk() const { return !folder_.empty() && trouble().empty(); }
  // The first problem with the disk, or "". Results were not stored on disk then, but the run continues.
  std::string trouble() const;
  // Bytes of values and records that this store wrote to the disk.
  std::uint64_t written() const { return written_; }
  ComputedTwice computed_twice() const;
  // Adds what was written to the bytes in use of the folder (CacheUsage). The store itself does so only now
  // and then, because that locks a file. Call it before tend_cache().
  void add_usage();

 private:
  void keep_in_memory(const Hash&, const Value&, std::uint64_t bytes, double seconds);
  Value find_in_memory(const Hash&);
  void move_to_its_place(TemporaryFile&, const OutputRecord&);
  void note_trouble(const std::string&);
  void note_usage(std::int64_t bytes);

  const ValueTypes& types_;
  std::filesystem::path folder_;
  std::uint64_t memory_, used_ = 0;
  std::atomic<std::uint64_t> written_{0};
  std::atomic<std::int64_t> usage_{0};  // bytes that CacheUsage does not know yet
  mutable std::mutex mutex_;
  // Greedy-dual eviction: at each use, a value's worth is set to its seconds per byte plus the worth of the
  // value evicted last. So cheap values and values that were not used for long are evicted first.
  struct Kept {
    Value value;
    std::uint64_t bytes;
    double per_byte, worth;
  };
  double left_worth_ = 0;
  std::unordered_map<Hash, Kept> values_;
  std::set<std::pair<double, Hash>> by_worth_;
  std::unordered_map<Hash, std::shared_ptr<const ActionRecord>> actions_;
  ComputedTwice twice_;
  std::string trouble_;
};

// Parses the content of a record file. Null if it is damaged or not a record.
std::shared_ptr<const ActionRecord> parse_action(const std::string& text);

}  // namespace terrazzo
