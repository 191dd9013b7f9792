#include "runtime/cli/made.h"

#include <unistd.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "graph/output_path.h"
#include "graph/raw_document.h"
#include "runtime/action_key.h"
#include "runtime/file_hashes.h"
#include "runtime/files.h"
#include "runtime/memory.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

Made made_from_report(const json& report) {
  Made made{report.at("document"), {}, {}};
  for (const auto& node : report.at("nodes")) {
    made.keys[node.at("name")] = node.at("key");
    if (node.contains("reads"))
      for (const auto& f : node.at("reads")) made.contents.insert(f.at("content"));
  }
  return made;
}

// A file's content as JSON, or null if it is not JSON. Throws Error "too-large" if parsing needs too much
// memory.
json json_in(const fs::path& path) {
  constexpr double per_byte = 40;  // of parsed JSON
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error) return nullptr;
  require_memory(per_byte * static_cast<double>(size), available_memory(), "'" + path.string() + "'");
  const auto text = read_file(path);
  return text ? json::parse(*text, nullptr, false) : json(nullptr);
}

// Formats without metadata fall back to a report.json in the file's folder or up to three folders above it.
std::optional<Made> made_by_report_beside(const fs::path& file) {
  const fs::path path = fs::absolute(file).lexically_normal();
  fs::path folder = path.parent_path();
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    const json report = json_in(folder / "report.json");
    if (!report.is_object() || !report.contains("document")) continue;
    const std::string name = path.lexically_relative(folder).string();
    for (const auto& node : report.at("nodes"))
      for (const auto& f : node.at("files"))
        if (f.at("path") == name) return made_from_report(report);
  }
  return {};
}

Made provenance_of(const fs::path& file, std::string (*read_provenance)(const fs::path&)) {
  if (::access(file.c_str(), R_OK) != 0) throw Error("usage", "cannot read '" + file.string() + "'");
  try {
    if (file.extension() == ".json")
      if (const json j = json_in(file); j.is_object() && j.contains("document")) return made_from_report(j);
    const std::string inside = read_provenance ? read_provenance(file) : "";
    if (const json j = json::parse(inside, nullptr, false); j.is_object() && j.contains("document")) {
      Made made{j.at("document"), {}, {}};
      for (const auto& [node, key] : j.at("keys").items()) made.keys[node] = key;
      if (j.contains("files"))
        for (const auto& f : j.at("files")) made.contents.insert(f.at("content"));
      return made;
    }
    if (const auto made = made_by_report_beside(file)) return *made;
  } catch (const json::exception& e) {
    throw Error("usage", "the provenance of '" + file.string() + "' is damaged: " + e.what());
  }
  throw Error("usage", "'" + file.string() + "' contains no provenance",
              "name a file that terrazzo wrote, or the report.json of its run");
}

// Subgraph files named in the document would be read without any check of their content.
void refuse_subgraphs(const Made& made) {
  Diagnostics ignored;
  for (const auto& node : read_document(made.document, "document.yaml", ignored).nodes)
    if (!node.graph.empty())
      throw Error("usage", "the graph that made this file refers to another graph file, '" + node.graph + "'",
                  "terrazzo writes self-contained graphs, so this one was modified");
}

// Whether the user grants access to the file.
bool granted(const fs::path& file, const std::vector<std::string>& folders) {
  std::error_code error;
  const fs::path real = fs::canonical(file, error);
  if (error) return false;
  for (const auto& folder : folders) {
    const fs::path root = fs::canonical(folder, error);
    if (!error && !leaves_folder(real.lexically_relative(root))) return true;
  }
  return false;
}

bool is_from_command_line(const SetParameter& p) { return p.place.file.starts_with("command line"); }

}  // namespace

Made how_made(const fs::path& file, std::string (*read_provenance)(const fs::path&)) {
  Made made = provenance_of(file, read_provenance);
  refuse_subgraphs(made);
  return made;
}

Graph open_made(const Registry& registry, const Made& made, const fs::path& file, const Overrides& overrides,
                Diagnostics& found) {
  fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  Graph first;
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    Diagnostics here;
    Graph graph = load_graph_text(made.document, folder / "document.yaml", registry, overrides, here);
    bool complete = true;
    for (const auto& node : graph.nodes)
      for (const auto& p : node.type->parameters)
        if (const auto it = node.parameters.find(p.name);
            p.kind == ParameterKind::InputPath && it != node.parameters.end())
          complete = complete && !expand_glob(std::get<std::string>(it->second.value)).empty();
    if (up == 0) first = graph, found = here;
    if (complete) return found = here, graph;
  }
  return first;
}

std::vector<MadeRead> reads_of(const Graph& graph, const Made& made,
                               const std::vector<std::string>& granted_folders) {
  FileHashes hashes;
  std::vector<MadeRead> out;
  for (const auto& node : graph.nodes)
    for (const auto& p : node.type->parameters) {
      const auto it = node.parameters.find(p.name);
      if (p.kind != ParameterKind::InputPath || it == node.parameters.end()) continue;
      for (const auto& path : expand_glob(std::get<std::string>(it->second.value)))
        for (const auto& f : files_opened(*node.type, path)) {
          MadeRead read{f, is_from_command_line(it->second) || granted(f, granted_folders), false};
          const auto content = read.granted ? std::nullopt : hashes.hash(f);
          read.named = content && made.contents.count(content->text());
          if (read.allowed() || fs::exists(f)) out.push_back(read);  // the run reports a missing file
        }
    }
  return out;
}

}  // namespace terrazzo::cli
