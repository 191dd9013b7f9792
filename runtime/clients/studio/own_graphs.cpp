#include "runtime/clients/studio/own_graphs.h"

#include <sys/stat.h>

#include <algorithm>
#include <optional>

#include "graph/input_file.h"
#include "runtime/bundle/bundle.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostGraphs = 60, kMostBundles = 24, kMostFiles = 20000;
constexpr int kDeepest = 4;

// Whether a YAML file says that it is a graph: a line that begins with "terrazzo:".
bool is_graph(const fs::path& file) {
  return ("\n" + read_beginning(file, 4096)).find("\nterrazzo:") != std::string::npos;
}

struct Found {
  std::string file;  // relative to the folder
  double changed;
  bool bundle;
};

// A file named bundle.json stands for the folder that it is in.
std::optional<Found> found(const fs::path& path, const Workspace& workspace) {
  const bool manifest = path.filename() == kBundleManifest;
  const auto extension = path.extension();
  const bool graph = extension == ".yaml" || extension == ".yml";
  struct stat status {};
  if ((!graph && !manifest && extension != ".zip") || ::stat(path.c_str(), &status) != 0 ||
      !S_ISREG(status.st_mode) || !workspace.contains(path) || (graph && !is_graph(path)) ||
      (extension == ".zip" && !is_bundle(path)))
    return {};
  const fs::path shown = manifest ? path.parent_path() : path;
  return Found{shown.lexically_relative(workspace.folder()).string(),
               status.st_mtim.tv_sec + 1e-9 * status.st_mtim.tv_nsec, !graph};
}

std::optional<OwnBundle> bundle_at(const std::string& file, const Workspace& workspace) try {
  const BundleInfo info = read_bundle_info(workspace.folder() / file);
  return OwnBundle{file, info.title.empty() ? file : info.title, info.doc, !info.preview.empty()};
} catch (const Error&) {
  return {};  // another zip archive
}

fs::path folder_of(const fs::path& archive, const fs::path& folder) { return folder / archive.stem(); }

}  // namespace

fs::path graph_of_bundle(const fs::path& bundle, const fs::path& folder, const Registry& registry) {
  if (fs::is_directory(bundle)) return check_bundle(bundle, registry);
  const fs::path own = folder_of(bundle, folder);
  if (!is_bundle(own)) extract_bundle(bundle, own, registry);
  return check_bundle(own, registry);
}

OwnFiles own_files(const Workspace& workspace) {
  std::vector<Found> all;
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
    if (name.starts_with('.')) continue;
    if (const auto f = found(it->path(), workspace)) all.push_back(*f);
  }
  std::ranges::sort(all, [](const auto& a, const auto& b) {
    return a.changed != b.changed ? a.changed > b.changed : a.file < b.file;
  });
  OwnFiles out;
  for (const Found& f : all) {
    if (!f.bundle && out.graphs.size() < kMostGraphs) out.graphs.push_back({f.file, f.changed});
    if (!f.bundle || out.bundles.size() >= kMostBundles || f.file == ".") continue;
    const fs::path path = workspace.folder() / f.file;
    if (path.extension() == ".zip" && is_bundle(folder_of(path, path.parent_path())))
      continue;  // listed itself
    if (const auto bundle = bundle_at(f.file, workspace)) out.bundles.push_back(*bundle);
  }
  return out;
}

}  // namespace terrazzo::studio
