#include "runtime/clients/studio/workspace.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "graph/text/utf8.h"
#include "runtime/files.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;

Workspace::Workspace(const fs::path& folder) : folder_(fs::weakly_canonical(folder)) {}

bool Workspace::contains(const fs::path& path) const { return is_inside(folder_, path); }

fs::path Workspace::resolve(const std::string& name) const {
  const bool control = std::ranges::any_of(name, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
  if (name.size() > 1000 || control || find_invalid_utf8(name) != std::string::npos ||
      name.find_first_of("*?[]$") != std::string::npos)
    throw Error("bad-name", "a name in a graph has no control characters and none of * ? [ ] $",
                "choose another name");
  const fs::path path = (folder_ / name).lexically_normal();
  if (!contains(path))
    throw Error("outside-folder", fmt::format("'{}' is not below '{}'", name, folder_.string()),
                "choose a name below that folder, or start terrazzo studio in another folder");
  return path;
}

}  // namespace terrazzo::studio
