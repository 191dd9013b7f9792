// Paths of files that nodes write.
#pragma once

#include <filesystem>

namespace terrazzo {

// Whether a path is absolute, empty, or leads out of the folder that it is relative to.
inline bool leaves_folder(const std::filesystem::path& path) {
  const std::filesystem::path normal = path.lexically_normal();
  return normal.is_absolute() || normal.empty() || *normal.begin() == "..";
}

}  // namespace terrazzo
