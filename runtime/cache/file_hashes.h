// Content hashes of input files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "runtime/hash.h"

namespace terrazzo {

// Detects changes to a file without reading it. A copy that keeps the modification time, a link that points
// to a different file, and an archive that restores old times all change at least one of these fields.
struct FileStamp {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t modified = 0, changed = 0;  // mtime and ctime in ns since 1970
  bool operator==(const FileStamp&) const = default;
};
// Returns nothing unless the path leads to a regular file.
std::optional<FileStamp> stamp_of(const std::filesystem::path&);

// Content hashes of files, remembered by path and stamp, and stored on disk between runs, for each machine,
// if there is a cache folder. Each hash belongs to one state of the file: if the file changes while it is
// read, it is read again. Thread-safe.
class FileHashes {
 public:
  explicit FileHashes(std::filesystem::path cache_folder = {}) : folder_(std::move(cache_folder)) {}
  // Returns nothing if the file cannot be read or keeps changing. Throws Error "too-large" if the hash is not
  // known yet and the file has more than `most` bytes.
  std::optional<Hash> hash(const std::filesystem::path&,
                           std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

 private:
  struct Entry {
    FileStamp stamp;
    Hash hash;
  };
  // What a line of the cache says; nothing if it is damaged.
  static std::optional<Entry> entry_in(std::string_view line);
  std::filesystem::path folder_;
  std::mutex mutex_;
  std::unordered_map<std::string, Entry> entries_;
};

}  // namespace terrazzo
