// The cache folder as a whole: what is in it, what may leave, what is damaged. Other processes may use the
// folder meanwhile.
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

inline constexpr std::uint64_t default_cache_limit = 20'000'000'000;

struct CacheStats {
  struct Kind {
    std::uint64_t count = 0, bytes = 0;  // bytes on the disk, in whole blocks
  };
  Kind records, values, other;          // other: file hashes, history, what interrupted writers left
  std::map<std::string, Kind> by_type;  // values
  double seconds = 0;                   // that the records' computations took
  std::uint64_t bytes() const { return records.bytes + values.bytes + other.bytes; }
};
CacheStats cache_stats(const std::filesystem::path& folder);

struct Collected {
  std::uint64_t values = 0, records = 0, leftovers = 0, bytes = 0;  // removed
  std::uint64_t left = 0;  // bytes that stay, records and all else included
  bool busy = false;       // another process is collecting: nothing was done
};
// Looks at every entry: removes what interrupted writers left more than an hour ago and what was not used for
// 90 days and saves nothing. If the folder takes more than `limit` bytes, brings it down to nine tenths of
// that: records that take more than a quarter of the limit leave first, the longest unused ones; then values,
// those that save the fewest seconds of computing per byte and day unused.
Collected collect_cache(const std::filesystem::path& folder, std::uint64_t limit);

// What a command does after it wrote to the cache. It takes about as long in a cache of a million entries as
// in an empty one: it looks at one of 256 parts, and beyond the limit at as many as it takes to free half a
// percent of it.
Collected tend_cache(const std::filesystem::path& folder, std::uint64_t limit);

// Removes every entry. Keeps the mark, and every file whose name this program does not give.
void clear_cache(const std::filesystem::path& folder);

struct Verified {
  std::uint64_t values = 0, records = 0;  // read and checked
  std::vector<std::string> damaged;       // files; removed
  std::uint64_t recomputed = 0;           // of the sample
  std::uint64_t passed_over = 0;          // other versions, inputs no longer there, nothing but files
  std::vector<std::string> differing;     // "Anneal 12ab…: particles", their records forgotten
};
// Reads every entry, and computes `sample` of them again, chosen by `seed`, to compare their content.
Verified verify_cache(const std::filesystem::path& folder, const Registry&, const ValueTypes&,
                      std::uint64_t sample, std::uint64_t seed, const Work&);

}  // namespace terrazzo
