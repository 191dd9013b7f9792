// A folder that only this user can enter, and that is removed with its content unless it gets a final name.
#pragma once

#include <filesystem>

namespace terrazzo {

class TemporaryFolder {
 public:
  // A new folder below `parent`. Throws Error "write-failed".
  explicit TemporaryFolder(const std::filesystem::path& parent);
  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&&) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  const std::filesystem::path& path() const { return path_; }
  // Gives it the usual permissions and its name, which no file may have. Throws Error "write-failed".
  void rename_to(const std::filesystem::path& final);

 private:
  std::filesystem::path path_;  // empty: it has gone
};

}  // namespace terrazzo
