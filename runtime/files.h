// Reading whole files, and writing files atomically.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/hash.h"

namespace terrazzo {

class ProtectedFiles;  // runtime/files/protected_files.h

// The existing files that match `pattern`, sorted. *, ? and [] match within one path component.
std::vector<std::filesystem::path> expand_glob(const std::filesystem::path& pattern);

// Whether a path lies in a folder once links are resolved, if it exists. `folder`: with its links resolved.
bool is_inside(const std::filesystem::path& folder, const std::filesystem::path&);

// A new, empty file in `folder` with a temporary name. The destructor removes it unless it was renamed. The
// name contains the host name and 64 random bits, so writers on other hosts and in other containers never
// choose the same one.
class TemporaryFile {
 public:
  // Creates the folder if necessary. `mode`: the permissions, from which the umask is taken away. Throws
  // Error "write-failed".
  TemporaryFile(const std::filesystem::path& folder, const std::string& stem,
                const std::string& extension = {}, unsigned mode = 0666);
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

// Throws Error "write-failed" if `final` is something that no file replaces: a folder, a device or a pipe.
// Call it before long work whose result goes there.
void require_replaceable(const std::filesystem::path& final);

// Every file of the user is written by these functions. They call `write` with the path of a temporary file
// in the folder of `final`, and rename it to `final` when `write` is done. On failure, any existing file at
// `final` is unchanged. Throw Error "overwrites-input" if `final` is one of the protected files whatever its
// path, "write-failed", or what `write` throws.
void write_atomically(const std::filesystem::path& final, const ProtectedFiles&,
                      const std::function<void(const std::filesystem::path& temporary)>& write);
void write_text_atomically(const std::filesystem::path& final, const ProtectedFiles&,
                           const std::string& text);
// The same where no graph is open, as for files of the cache.
void write_atomically(const std::filesystem::path& final,
                      const std::function<void(const std::filesystem::path& temporary)>& write);
void write_text_atomically(const std::filesystem::path& final, const std::string& text);
// Writes the whole text to an open file. Throws Error "write-failed", which names `final`.
void write_all(int descriptor, const std::string& text, const std::filesystem::path& final);

// Larger files are no text that this program reads: records, reports, logs, and values that it checks first.
inline constexpr std::uint64_t kMostTextBytes = std::uint64_t{1} << 30;

// The content of a regular file. Nothing if it cannot be read or has more bytes.
std::optional<std::string> read_file(const std::filesystem::path&, std::uint64_t most = kMostTextBytes);

}  // namespace terrazzo
