// Files read whole, and files written whole or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/hash.h"

namespace terrazzo {

// Existing files that `pattern` names, sorted; * and ? stand for characters of a name. Empty where there are
// none.
std::vector<std::filesystem::path> expand_glob(const std::filesystem::path& pattern);

// A new, empty file in `folder` under a temporary name, removed unless it is renamed. The name holds the host
// and 64 random bits, so writers on other hosts and in other containers never share one.
class TemporaryFile {
 public:
  // Makes the folder too. Throws Error "write-failed".
  TemporaryFile(const std::filesystem::path& folder, const std::string& stem,
                const std::string& extension = {});
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }
  // Syncs the file, gives it its final name, on the same file system, and syncs that folder. Throws Error
  // "write-failed"; what stood under the final name is then untouched.
  void rename_to(const std::filesystem::path& final);

 private:
  std::filesystem::path path_;
};
// Whether a name is one that TemporaryFile gives to a file with this stem.
bool is_temporary_name(const std::string& name, const std::string& stem);

// Calls `write` with the path of a temporary file beside `final`, and renames it once it is whole. On any
// failure nothing is left under the final name but what stood there before. Throws Error "write-failed", or
// what `write` throws.
void write_atomically(const std::filesystem::path& final,
                      const std::function<void(const std::filesystem::path& temporary)>& write);
void write_text_atomically(const std::filesystem::path& final, const std::string& text);

std::optional<std::string> read_file(const std::filesystem::path&);

}  // namespace terrazzo
