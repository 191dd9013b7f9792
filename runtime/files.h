// Reading whole files, and writing files atomically.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/hash.h"

namespace terrazzo {

// The existing files that match `pattern`, sorted. *, ? and [] match within one path component.
std::vector<std::filesystem::path> expand_glob(const std::filesystem::path& pattern);

// A new, empty file in `folder` with a temporary name. The destructor removes it unless it was renamed. The
// name contains the host name and 64 random bits, so writers on other hosts and in other containers never
// choose the same one.
class TemporaryFile {
 public:
  // Creates the folder if necessary. Throws Error "write-failed".
  TemporaryFile(const std::filesystem::path& folder, const std::string& stem,
                const std::string& extension = {});
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }
  // Syncs the file, renames it to `final`, which must be on the same file system, and syncs the folder.
  // Throws Error "write-failed", also if `final` is a device or a pipe, and then leaves what is at `final` as
  // it was.
  void rename_to(const std::filesystem::path& final);

 private:
  std::filesystem::path path_;
};
// Whether TemporaryFile could have chosen this name for a file with this stem and no extension.
bool is_temporary_name(const std::string& name, const std::string& stem);

// Calls `write` with the path of a temporary file in the folder of `final`, and renames it to `final` when
// `write` is done. On failure, any existing file at `final` is unchanged. Throws Error "write-failed", or
// what `write` throws.
void write_atomically(const std::filesystem::path& final,
                      const std::function<void(const std::filesystem::path& temporary)>& write);
void write_text_atomically(const std::filesystem::path& final, const std::string& text);

// The content of a regular file. Nothing if it cannot be read.
std::optional<std::string> read_file(const std::filesystem::path&);

}  // namespace terrazzo
