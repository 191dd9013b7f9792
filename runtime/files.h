// Files as inputs by content, and files written whole or not at all.
#pragma once

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

// Content hashes of files, memoised by path, size and modification time; kept on disk between runs where a
// folder is given. Safe for several threads.
class FileHashes {
 public:
  explicit FileHashes(std::filesystem::path folder = {}) : folder_(std::move(folder)) {}
  // Nothing where the file cannot be read.
  std::optional<Hash> hash(const std::filesystem::path&);

 private:
  struct Entry {
    std::uintmax_t size;
    std::int64_t time;
    Hash hash;
  };
  std::filesystem::path folder_;
  std::mutex mutex_;
  std::unordered_map<std::string, Entry> entries_;
};

// Calls `write` with a temporary path beside `final`, syncs what it wrote and renames it. On any failure
// nothing is left under the final name but what stood there before. Throws Error "write-failed", or what
// `write` throws.
void write_atomically(const std::filesystem::path& final,
                      const std::function<void(const std::filesystem::path& temporary)>& write);
void write_text_atomically(const std::filesystem::path& final, const std::string& text);

std::optional<std::string> read_file(const std::filesystem::path&);

}  // namespace terrazzo
