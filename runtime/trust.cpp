#include "runtime/trust.h"

#include <sys/stat.h>
#include <unistd.h>

namespace terrazzo {
namespace fs = std::filesystem;

std::string who_else_may_write(const fs::path& path, bool group) {
  std::error_code error;
  fs::path at = fs::weakly_canonical(fs::absolute(path), error);
  if (error) return "'" + path.string() + "' cannot be resolved: " + error.message();
  for (bool itself = true;; at = at.parent_path(), itself = false) {
    struct stat s;
    if (::lstat(at.c_str(), &s) == 0) {
      if (s.st_uid != ::geteuid() && s.st_uid != 0) return "'" + at.string() + "' belongs to another user";
      // In a folder with the sticky bit, such as /tmp, users cannot rename or remove other users' files.
      const bool shared_safely = !itself && S_ISDIR(s.st_mode) && (s.st_mode & S_ISVTX);
      if (!shared_safely && (s.st_mode & S_IWOTH)) return "everybody may write to '" + at.string() + "'";
      if (!shared_safely && group && (s.st_mode & S_IWGRP) && s.st_gid != ::getegid() && s.st_gid != 0)
        return "another group may write to '" + at.string() + "'";
    }
    if (at == at.parent_path()) return "";
  }
}

}  // namespace terrazzo
