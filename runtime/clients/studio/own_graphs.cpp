#include "runtime/clients/studio/own_graphs.h"

#include <sys/stat.h>

#include <algorithm>

#include "graph/input_file.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostGraphs = 60, kMostFiles = 20000;
constexpr int kDeepest = 4;

// Whether a YAML file says that it is a graph: a line that begins with "terrazzo:".
bool is_graph(const fs::path& file) {
  return ("\n" + read_beginning(file, 4096)).find("\nterrazzo:") != std::string::npos;
}

}  // namespace

std::vector<OwnGraph> own_graphs(const Workspace& workspace) {
  std::vector<OwnGraph> out;
  std::size_t seen = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator
           it(workspace.folder(), fs::directory_options::skip_permission_denied, error),
       end;
       !error && it != end && ++seen <= kMostFiles; it.increment(error)) {
    const std::string name = it->path().filename().string();
    std::error_code ignored;
    if (it->is_directory(ignored)) {
      if (name.starts_with('.') || it.depth() >= kDeepest) it.disable_recursion_pending();
      continue;
    }
    const auto extension = it->path().extension();
    struct stat status {};
    if (name.starts_with('.') || (extension != ".yaml" && extension != ".yml") ||
        ::stat(it->path().c_str(), &status) != 0 || !S_ISREG(status.st_mode) ||
        !workspace.contains(it->path()) || !is_graph(it->path()))
      continue;
    out.push_back({it->path().lexically_relative(workspace.folder()).string(),
                   status.st_mtim.tv_sec + 1e-9 * status.st_mtim.tv_nsec});
  }
  std::ranges::sort(out, [](const auto& a, const auto& b) {
    return a.changed != b.changed ? a.changed > b.changed : a.file < b.file;
  });
  if (out.size() > kMostGraphs) out.resize(kMostGraphs);
  return out;
}

}  // namespace terrazzo::studio
