// The cache folder: its layout, and the mark that distinguishes it from a user's folder.
//
//   terrazzo-cache        the format version; marks the folder as a cache
//   CACHEDIR.TAG          makes backup programs skip the folder (bford.info/cachedir)
//   usage                 bytes in use, and the part that tend_cache() inspects next
//   lock                  held by the process that is collecting
//   actions|values|files|history/ab/ab0123…    entries, named by a hash of 32 hexadecimal digits
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "runtime/hash.h"

namespace terrazzo {

inline constexpr std::array kCacheTables = {"actions", "values", "files", "history"};

// Creates the folder if it is missing, accessible only to the user, and marks it. Accepts an unmarked folder
// from an earlier version if it contains nothing but cache entries. Throws Error "not-a-cache" if the folder
// contains anything else, "unsafe-folder" if everybody may write to it, "cache-unusable" if it cannot be
// created or read, or if its mark is damaged or of another version. A run continues without a cache that is
// unusable.
void open_cache_folder(const std::filesystem::path&);

// Whether the folder exists and is marked as a cache of this version.
bool is_cache_folder(const std::filesystem::path&);
// Throws Error "usage", which says why it is none.
void require_cache_folder(const std::filesystem::path&);

// The path of an entry.
std::filesystem::path cache_entry(const std::filesystem::path& folder, const char* table, const Hash&);

// The disk space that a file of this size occupies, in whole blocks of 4096 bytes.
inline std::uint64_t bytes_on_disk(std::uint64_t size) { return (size + 4095) / 4096 * 4096; }

// Writes a text entry. Returns by how many bytes this changes the bytes in use, which the caller passes to
// CacheUsage. Throws Error "write-failed".
std::int64_t write_cache_entry(const std::filesystem::path& folder, const char* table, const Hash&,
                               const std::string& text);

struct CacheFile {
  std::filesystem::path path;
  Hash name;            // zero for a leftover file
  std::uint64_t bytes;  // disk space: bytes_on_disk()
  double age;           // seconds since its last use; 0 if its time is in the future
};

// Visits the entries and the leftover files of interrupted writers in one of a table's 256 parts, or in all
// parts if `part` < 0. Skips files whose names this program would not choose, and files that disappear
// meanwhile.
void each_cache_file(const std::filesystem::path& folder, const char* table, int part,
                     const std::function<void(const CacheFile&)>&);

// The bytes in use, shared by all processes. Writers add to it; collecting sets it. Each call locks a file,
// so writers on a shared folder add many entries at a time.
class CacheUsage {
 public:
  explicit CacheUsage(const std::filesystem::path& folder) : file_(folder / "usage") {}
  // Adds bytes and returns the sum, or UINT64_MAX if the sum is unknown, for example after an upgrade.
  std::uint64_t add(std::int64_t bytes) const;
  void set(std::uint64_t bytes) const;
  // The part that tend_cache() inspects next. Counts from 0 to 255, then starts over.
  int next_part() const;

 private:
  template <class Change>
  auto change(Change) const;
  std::filesystem::path file_;
};

// Holds the cache lock during the object's lifetime. held() is false if another process has the lock.
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
