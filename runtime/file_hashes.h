// Files as inputs by content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "runtime/hash.h"

namespace terrazzo {

// What tells one state of a file from another without reading it. A copy that keeps the modification time,
// a link that points elsewhere and an archive that restores old times all change at least one of these.
struct FileStamp {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t modified = 0, changed = 0;  // ns since 1970: content, and content or attributes
  bool operator==(const FileStamp&) const = default;
};
// Nothing unless the path leads to a regular file.
std::optional<FileStamp> stamp_of(const std::filesystem::path&);

// Content hashes of files, remembered by path and stamp, and kept on disk between runs if a cache folder is
// given. A hash is of one state of the file: if the file changes while it is read, it is read again. Safe for
// several threads.
class FileHashes {
 public:
  explicit FileHashes(std::filesystem::path cache_folder = {}) : folder_(std::move(cache_folder)) {}
  // Nothing where the file cannot be read.
  std::optional<Hash> hash(const std::filesystem::path&);

 private:
  struct Entry {
    FileStamp stamp;
    Hash hash;
  };
  std::filesystem::path folder_;
  std::mutex mutex_;
  std::unordered_map<std::string, Entry> entries_;
};

}  // namespace terrazzo
