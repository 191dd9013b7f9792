// Files as inputs by content, and files written whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/hash.h"

namespace terrazzo {

// Existing files that `pattern` names, sorted; * and ? stand for characters of a name. Empty where there are
// none.
std::vector<std::filesystem::path> expand_glob(const std::filesystem::path& pattern);

// What tells one state of a file from another without reading it. A copy that keeps the modification time,
// a link that points elsewhere and an archive that restores old times all change at least one of these.
struct FileStamp {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t modified = 0, changed = 0;  // ns since 1970: content, and content or attributes
  bool operator==(const FileStamp&) const = default;
};
// Nothing unless the path leads to a regular file.
std::optional<FileStamp> stamp_of(const std::filesystem::path&);

// Content hashes of files, remembered by path and stamp, and kept on disk between runs if a folder is given.
// A hash is of one state of the file: if the file changes while it is read, it is read again. Safe for several
// threads.
class FileHashes {
 public:
  explicit FileHashes(std::filesystem::path folder = {}) : folder_(std::move(folder)) {}
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

// Calls `write` with the path of a new, empty temporary file beside `final`, syncs what it wrote, renames it and
// syncs the folder. On any failure nothing is left under the final name but what stood there before. The
// temporary name holds the host and 64 random bits, so writers on other hosts and in other containers never
// share one. Throws Error "write-failed", or what `write` throws.
void write_atomically(const std::filesystem::path& final,
                      const std::function<void(const std::filesystem::path& temporary)>& write);
// Makes the names in a folder last through a power failure.
void sync_folder(const std::filesystem::path&);
void write_text_atomically(const std::filesystem::path& final, const std::string& text);

std::optional<std::string> read_file(const std::filesystem::path&);

}  // namespace terrazzo
