// A set of files, whatever the paths that name them.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace terrazzo {

// Paths name the same file if they lead to one file through links, `.` and `..`, another spelling that the
// file system accepts, or a second name (hard link). A path that leads to no file names its place: the
// folder, with links resolved, and the name.
class FileSet {
 public:
  void add(const std::filesystem::path&);
  // The path in the set that names this file, or null. A link in the set also protects its own place.
  const std::filesystem::path* find(const std::filesystem::path&) const;
  std::size_t size() const { return by_place_.size(); }

 private:
  std::map<std::pair<dev_t, ino_t>, std::filesystem::path> by_number_;
  std::map<std::string, std::filesystem::path> by_place_;
};

// The folder of a path with its links resolved, and the name. Absolute.
std::filesystem::path place_of(const std::filesystem::path&);

}  // namespace terrazzo
