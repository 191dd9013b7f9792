#include "runtime/bundle/write_bundle.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "graph/describe.h"
#include "graph/document/edit_document.h"
#include "graph/graph.h"
#include "runtime/bundle/bundle.h"
#include "runtime/bundle/temporary_folder.h"
#include "runtime/bundle/zip_file.h"
#include "runtime/cache/action_key.h"
#include "runtime/files.h"
#include "runtime/files/protected_files.h"
#include "runtime/json_text.h"
#include "runtime/report/methods.h"
#include "runtime/report/provenance.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMostLicense = 1 << 20;

bool is_under(const fs::path& folder, const fs::path& file) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

// Files that refer to each other by relative paths, and so keep their places relative to each other.
struct Island {
  std::string target;        // its place in the bundle: "", "files/" or "files/2/"
  fs::path folder;           // that contains all its files
  std::set<fs::path> files;  // absolute

  void add(const fs::path& file) {
    const fs::path parent = file.parent_path();
    if (files.empty()) folder = parent;
    while (!is_under(folder, parent)) folder = folder.parent_path();
    files.insert(file);
  }
  std::string name_of(const fs::path& file) const {
    return target + file.lexically_relative(folder).generic_string();
  }
};

struct GraphText {
  std::size_t island;
  RawDocument doc;
  std::string text;
};

// What goes into a bundle, and under which name.
class Collection {
 public:
  Collection(const BundleRequest& request, const Registry& registry) : registry_(registry) {
    const fs::path file = fs::absolute(request.graph).lexically_normal();
    add_island();
    add_graph(0, file, request.text);
    for (std::size_t k = 0; k < order_.size(); ++k) follow(order_[k]);
    Diagnostics found;
    graph_ = load_graph_text(graphs_.at(file).text, file, registry, {}, found);
    for (const Diagnostic& d : found)
      if (d.severity == Severity::Error) throw Error(d);
    for (const GraphNode& node : graph_.nodes) add_inputs(node);
    add_licenses();
    const fs::path arrangement = file.string() + ".studio.json";
    if (std::error_code error; fs::is_regular_file(arrangement, error)) islands_[0].add(arrangement);
  }

  const Graph& graph() const { return graph_; }
  std::string name_of_graph() const { return islands_[0].name_of(order_.front()); }

  std::vector<BundleFile> files() {
    std::vector<BundleFile> out;
    for (const fs::path& file : order_) {
      const GraphText& g = graphs_.at(file);
      out.push_back({islands_[g.island].name_of(file), {}, rewritten(file, g)});
    }
    for (const Island& island : islands_)
      for (const fs::path& file : island.files)
        if (!graphs_.count(file)) out.push_back({island.name_of(file), file, {}});
    return out;
  }

 private:
  std::size_t add_island() {
    const std::size_t n = islands_.size();
    islands_.push_back({n == 0 ? "" : n == 1 ? "files/" : fmt::format("files/{}/", n), {}, {}});
    return n;
  }

  void add_graph(std::size_t island, const fs::path& file, const std::optional<std::string>& given = {}) {
    if (graphs_.count(file)) return;
    Diagnostics found;
    const auto text = given ? given : read_graph_text(file, found);
    if (!text) throw Error(found.front());
    graphs_[file] = {island, read_document(*text, file, found), *text};
    order_.push_back(file);
    islands_[island].add(file);
  }

  // Calls `use` for each file that a graph names: its text, and the edit that would replace it.
  template <class Use>
  void for_each_reference(const GraphText& g, Use&& use) const {
    const auto path = [&](const Parameter& p, const WrittenValue& v, const Edit& edit) {
      const std::string text = v.is_list || v.items.empty() ? "" : v.text();
      if (p.kind == ParameterKind::InputPath && !text.empty() && std::ranges::count(p.keywords, text) == 0)
        use(text, edit);
    };
    for (const RawParameter& p : g.doc.parameters)
      path(p.declaration, p.value.written, {.kind = Edit::Kind::SetDefault, .name = p.declaration.name});
    for (const RawNode& n : g.doc.nodes) {
      NodeType subgraph("", 0);
      const NodeType* type = n.graph.empty() ? registry_.find(n.type) : &subgraph;
      if (!n.graph.empty()) {
        use(n.graph, Edit{.kind = Edit::Kind::SetSubgraph, .node = n.name});
        Diagnostics ignored;
        subgraph = describe_graph(
            load_graph((g.doc.file.parent_path() / n.graph).lexically_normal(), registry_, {}, ignored));
      }
      for (const auto& [name, value] : n.params)
        if (const Parameter* p = type ? type->find_parameter(name) : nullptr)
          path(*p, value.written, {.kind = Edit::Kind::SetParameter, .node = n.name, .name = name});
    }
  }

  // Subgraphs, and islands for what has an absolute path.
  void follow(const fs::path& file) {
    const GraphText g = graphs_.at(file);
    for_each_reference(g, [&](const std::string& text, const Edit& edit) {
      const bool absolute = fs::path(text).is_absolute();
      if (absolute && text.find("${") != std::string::npos)
        throw Error("cannot-bundle",
                    fmt::format("{}: '{}' is absolute and contains a parameter", file.string(), text),
                    "write it relative to the graph's folder");
      const fs::path named = (absolute ? fs::path(text) : file.parent_path() / text).lexically_normal();
      if (absolute && !absolute_.count(named))
        absolute_[named] = graphs_.count(named) ? graphs_.at(named).island : add_island();
      if (edit.kind == Edit::Kind::SetSubgraph) add_graph(absolute ? absolute_.at(named) : g.island, named);
    });
  }

  void add_inputs(const GraphNode& node) {
    for (const Parameter& p : node.type->parameters) {
      const auto it = node.parameters.find(p.name);
      if (p.kind != ParameterKind::InputPath || it == node.parameters.end()) continue;
      const fs::path named = std::get<std::string>(it->second.value);
      const auto known = absolute_.find(named);
      const auto from = graphs_.find(fs::absolute(it->second.place.file).lexically_normal());
      const std::size_t island = known != absolute_.end() ? known->second
                                 : from != graphs_.end()  ? from->second.island
                                                          : 0;
      const auto found = expand_glob(named);
      if (found.empty())
        throw Error("no-file",
                    fmt::format("'{}' reads '{}', which does not exist", node.path, named.string()));
      for (const fs::path& file : found)
        for (const fs::path& opened : files_opened(*node.type, file))
          islands_[island].add(opened.lexically_normal());
    }
  }

  // Files that state how the others may be used.
  void add_licenses() {
    for (Island& island : islands_) {
      std::set<fs::path> folders;
      for (const fs::path& file : island.files) folders.insert(file.parent_path());
      for (const fs::path& folder : folders)
        for (const char* name : {"LICENSE*", "COPYING*", "NOTICE*", "SOURCES*"})
          for (const fs::path& file : expand_glob(folder / name))
            if (std::error_code error;
                fs::is_regular_file(file, error) && fs::file_size(file, error) <= kMostLicense)
              island.add(file);
    }
  }

  // The text of a graph for its place in the bundle.
  std::string rewritten(const fs::path& file, const GraphText& g) const {
    std::string out = g.text;
    const fs::path folder = fs::path("/" + islands_[g.island].name_of(file)).parent_path();
    for_each_reference(g, [&](const std::string& text, Edit edit) {
      if (!fs::path(text).is_absolute()) return;
      const fs::path named = fs::path(text).lexically_normal();
      const std::string now = fs::path("/" + islands_[absolute_.at(named)].name_of(named))
                                  .lexically_relative(folder)
                                  .generic_string();
      if (edit.kind == Edit::Kind::SetSubgraph)
        edit.graph = now;
      else
        edit.value = {false, {now}, {}};
      out = edit_document(out, file, edit);
    });
    return out;
  }

  const Registry& registry_;
  std::deque<Island> islands_;
  std::map<fs::path, GraphText> graphs_;
  std::deque<fs::path> order_;                // of graphs_, the first one first
  std::map<fs::path, std::size_t> absolute_;  // islands of what has an absolute path
  Graph graph_;
};

std::string notes(const BundleRequest& request, const Graph& graph, const std::string& name,
                  const std::vector<BundleFile>& files, const Registry& registry) {
  std::string out = fmt::format("# {}\n\n", graph.name.empty() ? name : graph.name);
  if (!graph.doc.empty()) out += graph.doc + "\n\n";
  out += fmt::format(
      "Open it with Terrazzo {} or later: `terrazzo run` or `terrazzo studio` with this folder or archive. "
      "The graph is `{}`.\n\n## License and sources\n\n",
      program_version, name);
  out += request.license.empty() ? "No license is stated.\n" : "License: " + request.license + "\n";
  if (!request.source.empty()) out += "Source: " + request.source + "\n";
  out += "\n## Files\n\n";
  for (const BundleFile& f : files) out += "- `" + f.name + "`\n";
  return out + "\n## Methods\n\n" + methods_text(graph, {}, registry, program_version);
}

void require_limits(const std::vector<BundleFile>& files) {
  std::uint64_t bytes = 0;
  std::set<std::string> names;
  for (const BundleFile& f : files) {
    if (const std::string why = trouble_with_name(f.name); !why.empty())
      throw Error("cannot-bundle", fmt::format("the name '{}' {}", printable(f.name), why),
                  "rename the file");
    bytes += f.from.empty() ? f.text.size() : fs::file_size(f.from);
  }
  if (bytes > kMostBundleBytes || files.size() > kMostBundleFiles)
    throw Error("too-large",
                fmt::format("the bundle would have {} files with {} MB; the limits are {} and {} MB",
                            files.size(), bytes / 1'000'000, kMostBundleFiles, kMostBundleBytes / 1'000'000));
}

void write_folder(const fs::path& folder, const std::vector<BundleFile>& files) {
  for (const BundleFile& f : files) {
    const fs::path to = folder / f.name;
    std::error_code error;
    fs::create_directories(to.parent_path(), error);
    if (!f.from.empty() && !error) fs::copy_file(f.from, to, error);
    if (error)
      throw Error("write-failed", fmt::format("cannot write '{}': {}", to.string(), error.message()));
    if (f.from.empty()) write_text_atomically(to, f.text);
  }
}

}  // namespace

void write_bundle(const fs::path& to, const BundleRequest& request, const Registry& registry) {
  const bool archive = to.extension() == ".zip";
  if (!archive && fs::exists(fs::symlink_status(to)))
    throw Error("file-exists", "'" + to.string() + "' exists already", "choose another name");
  Collection all(request, registry);
  std::vector<BundleFile> files = all.files();
  const std::string graph = all.name_of_graph();
  files.push_back({"NOTES.md", {}, notes(request, all.graph(), graph, files, registry)});
  nlohmann::json manifest = {
      {"terrazzo_bundle", kBundleFormat}, {"version", program_version}, {"graph", graph},
      {"title", all.graph().name},        {"doc", all.graph().doc},     {"license", request.license},
      {"source", request.source}};
  if (!request.preview.empty()) {
    files.push_back({"bundle_preview" + request.preview.extension().string(), request.preview, {}});
    manifest["preview"] = files.back().name;
  }
  files.push_back({kBundleManifest, {}, json_text(manifest, 2) + "\n"});
  require_limits(files);
  if (!archive) {
    TemporaryFolder made(fs::absolute(to).parent_path());
    write_folder(made.path(), files);
    check_bundle(made.path(), registry);
    made.rename_to(to);
    return;
  }
  write_atomically(to, ProtectedFiles(all.graph()), [&](const fs::path& temporary) {
    write_zip(temporary, files);
    const TemporaryFolder again(fs::temp_directory_path());
    extract_zip(temporary, again.path());
    check_bundle(again.path(), registry);
  });
}

}  // namespace terrazzo
