#include "graph/document/file_set.h"

#include <sys/stat.h>

namespace terrazzo {
namespace fs = std::filesystem;

fs::path place_of(const fs::path& path) {
  std::error_code error;
  const fs::path full = fs::absolute(path, error);
  const fs::path name = full.filename();
  // Not simplified as text first: after a link, `..` leads to the folder of what the link refers to.
  if (name == "." || name == ".." || name.empty()) return fs::weakly_canonical(full, error);
  const fs::path folder = fs::weakly_canonical(full.parent_path(), error);
  return (error ? full.parent_path() : folder) / name;
}

void FileSet::add(const fs::path& path) {
  struct stat s;
  if (::stat(path.c_str(), &s) == 0) by_number_.emplace(std::pair(s.st_dev, s.st_ino), path);
  by_place_.emplace(place_of(path).string(), path);
}

const fs::path* FileSet::find(const fs::path& path) const {
  if (const auto it = by_place_.find(place_of(path).string()); it != by_place_.end()) return &it->second;
  struct stat s;
  if (::stat(path.c_str(), &s) != 0) return nullptr;
  const auto it = by_number_.find({s.st_dev, s.st_ino});
  return it == by_number_.end() ? nullptr : &it->second;
}

}  // namespace terrazzo
