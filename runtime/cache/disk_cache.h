// Maintenance of the cache folder: statistics, collection, verification. Other processes may use the folder
// at the same time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "graph/registry.h"
#include "runtime/value.h"
#include "runtime/work.h"

namespace terrazzo {

inline constexpr std::uint64_t kDefaultCacheLimit = 20'000'000'000;

struct CacheStats {
  struct Kind {
    std::uint64_t count = 0, bytes = 0;  // bytes: disk space in whole blocks
  };
  Kind records, values, other;          // other: file hashes, history, leftover temporary files
  std::uint64_t in_records = 0;         // number of small values, which are part of their records
  std::map<std::string, Kind> by_type;  // all values by value type; bytes: of those with files of their own
  double seconds = 0;                   // total computing time of the records
  std::uint64_t bytes() const { return records.bytes + values.bytes + other.bytes; }
};
CacheStats cache_stats(const std::filesystem::path& folder);

struct Collected {
  std::uint64_t values = 0, records = 0, leftovers = 0, bytes = 0;  // removed
  std::uint64_t left = 0;  // bytes that remain in use, including records and all other files
  bool busy = false;       // another process is collecting, so the cache was not reduced
};
// Inspects every entry. Removes temporary files of interrupted writers after an hour. Removes file hashes,
// history and records whose values are gone after 90 days without use. If the folder then exceeds `limit`
// bytes, reduces it to nine tenths of the limit. Records are removed only as long as they take more than a
// quarter of that, least recently used first; then values, starting with those that save the fewest seconds
// of computing per byte and day unused.
Collected collect_cache(const std::filesystem::path& folder, std::uint64_t limit);

// The upkeep after a command wrote to the cache. It inspects only one of the 256 parts, so it stays fast even
// with a million entries. Above the limit, it inspects as many parts as it needs to get 0.5 % below it. Small
// caches are collected completely.
Collected tend_cache(const std::filesystem::path& folder, std::uint64_t limit);

// Removes all entries. Keeps the mark and all files whose names this program would not choose. Throws Error
// "cache-clear".
void clear_cache(const std::filesystem::path& folder);

struct Verified {
  std::uint64_t values = 0, records = 0;  // read and checked
  // Paths of files that were removed: damaged ones, and records without the outputs of their node types.
  std::vector<std::string> damaged;
  std::uint64_t lost = 0;              // records with values that the cache no longer has
  std::uint64_t recomputed = 0;        // number of recomputed records
  std::uint64_t passed_over = 0;       // skipped: other version, inputs gone, or writes files
  std::vector<std::string> differing;  // "Anneal 12ab…: particles"; their records were removed
};
// Checks every entry, recomputes `sample` records chosen by `seed`, and compares the results. Throws
// Cancelled, or the Error of a recomputed node.
Verified verify_cache(const std::filesystem::path& folder, const Registry&, const ValueTypes&,
                      std::uint64_t sample, std::uint64_t seed, const Work&);

}  // namespace terrazzo
