// The folder below which the page may create files.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo::studio {

class Workspace {
 public:
  explicit Workspace(const std::filesystem::path& folder = std::filesystem::current_path());

  const std::filesystem::path& folder() const { return folder_; }
  bool contains(const std::filesystem::path&) const;

  // A file or folder below the folder, which does not need to exist. Throws Error "bad-name" for a name that
  // no graph can refer to, "outside-folder" if it lies elsewhere, also by a symbolic link.
  std::filesystem::path resolve(const std::string& name) const;

 private:
  std::filesystem::path folder_;  // canonical
};

}  // namespace terrazzo::studio
