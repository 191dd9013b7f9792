#include "runtime/bundle/bundle.h"

#include <fmt/format.h>

#include <algorithm>
#include <list>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "graph/document/raw_document.h"
#include "graph/graph.h"
#include "graph/input_file.h"
#include "runtime/bundle/temporary_folder.h"
#include "runtime/bundle/zip_file.h"
#include "runtime/cache/file_hashes.h"
#include "runtime/files.h"
#include "runtime/files/json_input.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr std::uint64_t kMostManifest = 1 << 20, kMostPreview = 64 << 20;

Error no_bundle(const fs::path& bundle, const std::string& why) {
  return Error("bad-bundle", fmt::format("'{}' is no bundle: {}", bundle.string(), why),
               "terrazzo bundle writes them");
}

std::optional<std::string> file_of(const fs::path& bundle, const std::string& name, std::uint64_t most) {
  if (!fs::is_directory(bundle)) return read_from_zip(bundle, name, most);
  if (!trouble_with_name(name).empty()) return {};
  const FileText file = read_input_file(bundle / name, most);
  return file ? std::optional(file.text) : std::nullopt;
}

std::string text_in(const json& j, const char* name) {
  const auto it = j.find(name);
  return it != j.end() && it->is_string() ? it->get<std::string>() : "";
}

class Inside {
 public:
  explicit Inside(const fs::path& folder) : folder_(fs::canonical(folder)) {}

  void require(const fs::path& file, const Place& place) const {
    if (is_inside(folder_, file)) return;
    throw Error(Diagnostic{Severity::Error, "outside-bundle",
                           fmt::format("'{}' is outside the bundle '{}'", file.string(), folder_.string()),
                           "a bundle refers only to its own files", place, "", ""});
  }

  // The graph's file and those of its subgraphs, before any of them is read.
  void require_graphs(const fs::path& file, const Place& place) {
    require(file, place);
    if (!seen_.insert(fs::weakly_canonical(file)).second) return;
    Diagnostics found;
    const auto text = read_graph_text(file, found);
    if (!text) throw Error(found.front());
    for (const RawNode& n : read_document(*text, file, found).nodes)
      if (!n.graph.empty()) require_graphs((file.parent_path() / n.graph).lexically_normal(), n.kind_place);
  }

  void require_inputs(const Graph& graph) const {
    for (const GraphNode& node : graph.nodes)
      for (const Parameter& p : node.type->parameters) {
        const auto it = node.parameters.find(p.name);
        if (p.kind != ParameterKind::InputPath || it == node.parameters.end()) continue;
        const fs::path path = std::get<std::string>(it->second.value);
        require(path, it->second.place);
        for (const fs::path& file : expand_glob(path)) require(file, it->second.place);
      }
  }

 private:
  fs::path folder_;
  std::set<fs::path> seen_;
};

}  // namespace

bool is_bundle(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) ? fs::is_regular_file(path / kBundleManifest, error)
                                       : is_zip_file(path);
}

BundleInfo read_bundle_info(const fs::path& bundle) {
  const auto text = file_of(bundle, kBundleManifest, kMostManifest);
  if (!text) throw no_bundle(bundle, "it has no file bundle.json");
  const json j = json_or_null(*text);
  const auto format = j.is_object() ? j.find("terrazzo_bundle") : j.end();
  if (!j.is_object() || format == j.end() || !format->is_number_integer())
    throw no_bundle(bundle, "bundle.json does not describe one");
  if (*format != kBundleFormat) throw no_bundle(bundle, "a newer version of terrazzo wrote it");
  const BundleInfo out{text_in(j, "graph"),   text_in(j, "title"),  text_in(j, "doc"),
                       text_in(j, "license"), text_in(j, "source"), text_in(j, "preview"),
                       text_in(j, "version")};
  if (const std::string why = trouble_with_name(out.graph); !why.empty())
    throw no_bundle(bundle, "the name of its graph " + why);
  return out;
}

std::optional<std::string> read_bundle_preview(const fs::path& bundle) {
  const std::string name = read_bundle_info(bundle).preview;
  return name.empty() ? std::nullopt : file_of(bundle, name, kMostPreview);
}

fs::path check_bundle(const fs::path& folder, const Registry& registry) {
  const fs::path file = fs::absolute(folder / read_bundle_info(folder).graph).lexically_normal();
  Inside inside(folder);
  inside.require_graphs(file, {});
  Diagnostics found;
  const Graph graph = load_graph(file, registry, {}, found);
  for (const Diagnostic& d : found)
    if (d.severity == Severity::Error) throw Error(d);
  inside.require_inputs(graph);
  return file;
}

fs::path open_bundle(const fs::path& bundle, const Registry& registry) {
  if (fs::is_directory(bundle)) return check_bundle(bundle, registry);
  static std::mutex mutex;
  static std::list<TemporaryFolder> extracted;  // removed when the process ends
  const std::lock_guard lock(mutex);
  TemporaryFolder folder(fs::temp_directory_path());
  extract_zip(bundle, folder.path());
  fs::path file = check_bundle(folder.path(), registry);
  extracted.push_back(std::move(folder));
  return file;
}

fs::path keep_bundle(const fs::path& bundle, const fs::path& folder, const Registry& registry) {
  if (fs::is_directory(bundle)) return check_bundle(bundle, registry);
  const auto hash = FileHashes().hash(bundle);
  if (!hash) throw no_bundle(bundle, "it cannot be read");
  const fs::path own = folder / (bundle.stem().string() + "-" + hash->text().substr(0, 12));
  std::error_code error;
  fs::create_directories(folder, error);
  if (!is_bundle(own)) extract_bundle(bundle, own, registry);
  return check_bundle(own, registry);
}

void extract_bundle(const fs::path& zip, const fs::path& folder, const Registry& registry) {
  if (fs::exists(fs::symlink_status(folder)))
    throw Error("file-exists", "'" + folder.string() + "' exists already", "rename it, or the bundle");
  TemporaryFolder made(fs::absolute(folder).parent_path());
  extract_zip(zip, made.path());
  check_bundle(made.path(), registry);
  made.rename_to(folder);
}

}  // namespace terrazzo
