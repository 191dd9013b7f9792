// The cache folder: how it is laid out, marked, and told from a folder of the user's.
//
//   terrazzo-cache        the format's version; its presence makes the folder ours
//   CACHEDIR.TAG          tells backup programs to skip the folder (bford.info/cachedir)
//   usage                 bytes in use, and the part that the next sweep looks at
//   lock                  held by the process that collects
//   actions|values|files|history/ab/ab0123…    entries, named by a hash of 32 hexadecimal digits
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "runtime/hash.h"

namespace terrazzo {

inline constexpr std::array cache_tables = {"actions", "values", "files", "history"};

// Makes the folder if it is missing, private to the user, and marks it. A folder of an earlier version, which
// has no mark, is taken over if it holds nothing but entries. Throws Error "not-a-cache" if the folder holds
// anything else or belongs to another version, "unsafe-folder" if everybody may write to it, "cache-unusable"
// if it cannot be made.
void open_cache_folder(const std::filesystem::path&);

// Whether the folder exists and is marked as a cache of this version.
bool is_cache_folder(const std::filesystem::path&);

// Where an entry lies.
std::filesystem::path cache_entry(const std::filesystem::path& folder, const char* table, const Hash&);

// A file of this size takes whole blocks of 4096 bytes.
inline std::uint64_t bytes_on_disk(std::uint64_t size) { return (size + 4095) / 4096 * 4096; }

// Writes an entry that is text and counts its bytes. Throws Error "write-failed".
void write_cache_entry(const std::filesystem::path& folder, const char* table, const Hash&,
                       const std::string& text);

struct CacheFile {
  std::filesystem::path path;
  Hash name;            // zero for a leftover
  std::uint64_t bytes;  // on the disk: bytes_on_disk
  double age;           // seconds since its last use; never negative, also if its time lies in the future
};

// Entries and leftovers of writers that were interrupted, in one of a table's 256 parts or, with `part` < 0,
// in all of them. Files whose names this program does not give are passed over, and so is what disappears
// meanwhile.
void each_cache_file(const std::filesystem::path& folder, const char* table, int part,
                     const std::function<void(const CacheFile&)>&);

// Bytes in use, shared by all processes: every writer adds, and who collects sets.
class CacheUsage {
 public:
  explicit CacheUsage(const std::filesystem::path& folder) : file_(folder / "usage") {}
  // Adds bytes and returns the sum; UINT64_MAX if nobody knows it, as after an upgrade.
  std::uint64_t add(std::int64_t bytes) const;
  void set(std::uint64_t bytes) const;
  // Counts from 0 to 255 and begins again: the part that the next sweep looks at.
  int next_part() const;

 private:
  template <class Change>
  auto change(Change) const;
  std::filesystem::path file_;
};

// Held while the object lives, unless another process has it.
class CacheLock {
 public:
  explicit CacheLock(const std::filesystem::path& folder);
  ~CacheLock();
  CacheLock(const CacheLock&) = delete;
  CacheLock& operator=(const CacheLock&) = delete;
  bool held() const { return held_; }

 private:
  int file_;
  bool held_;
};

}  // namespace terrazzo
