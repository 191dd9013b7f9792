#include "runtime/clients/cli/completion/complete_file.h"

#include <algorithm>
#include <filesystem>

namespace terrazzo::cli {
namespace fs = std::filesystem;

std::vector<std::string> complete_file(const std::string& typed, FileKind kind) {
  const std::string folder = typed.substr(0, typed.rfind('/') + 1);  // "" or with its '/'
  const std::string start = typed.substr(folder.size());
  std::vector<std::string> out;
  std::error_code error, ignored;
  for (fs::directory_iterator it(folder.empty() ? "." : folder, error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with(start) || (name[0] == '.' && start.empty())) continue;
    const auto extension = it->path().extension();
    if (it->is_directory(ignored))
      out.push_back(folder + name + "/");
    else if (kind == FileKind::any ||
             (kind == FileKind::graph && (extension == ".yaml" || extension == ".yml")))
      out.push_back(folder + name);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace terrazzo::cli
