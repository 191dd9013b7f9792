#include "runtime/bundle/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder(const fs::path& parent) {
  std::string name = (parent / ".terrazzo-bundle-XXXXXX").string();
  if (!::mkdtemp(name.data()))
    throw Error("write-failed", "cannot create a folder in '" + parent.string() +
                                    "': " + std::generic_category().message(errno));
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

void TemporaryFolder::rename_to(const fs::path& final) {
  std::error_code error;
  fs::permissions(path_, fs::perms(0755), error);
  if (!error) fs::rename(path_, final, error);
  if (error) throw Error("write-failed", "cannot create '" + final.string() + "': " + error.message());
  path_.clear();
}

}  // namespace terrazzo
