#include "runtime/clients/cli/made.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "graph/document/raw_document.h"
#include "graph/input_file.h"
#include "graph/output_path.h"
#include "runtime/cache/action_key.h"
#include "runtime/cache/file_hashes.h"
#include "runtime/files.h"
#include "runtime/files/json_input.h"
#include "runtime/memory.h"
#include "runtime/report/report_format.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

Made made_from_report(const json& report, const fs::path& file, const ValueTypes& types) {
  check_report_format(report, file);
  Made made{
      report.at("document"), {}, {}, {}, {}, give_values(report.value("values", json::object()), types)};
  for (const auto& node : report.at("nodes")) {
    made.keys[node.at("name")] = node.at("key");
    if (node.contains("reads"))
      for (const auto& f : node.at("reads")) {
        made.contents.insert(f.at("content"));
        made.contents_of[node.at("name")].insert(f.at("content"));
        made.places.push_back(f.at("path").get<std::string>());
      }
  }
  return made;
}

// Formats without metadata fall back to a report.json in the file's folder or up to three folders above it.
std::optional<Made> made_by_report_beside(const fs::path& file, const ValueTypes& types) {
  const fs::path path = fs::absolute(file).lexically_normal();
  fs::path folder = path.parent_path();
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    const json report = read_json_file(folder / "report.json");
    if (!report.is_object() || !report.contains("document")) continue;
    const std::string name = path.lexically_relative(folder).string();
    for (const auto& node : report.at("nodes"))
      for (const auto& f : node.at("files"))
        if (f.at("path") == name) return made_from_report(report, folder / "report.json", types);
  }
  return {};
}

Made provenance_of(const fs::path& file, const ValueTypes& types,
                   std::string (*read_provenance)(const fs::path&)) {
  if (const InputFile opened(file); !opened)
    throw Error("usage", "cannot read '" + file.string() + "': " + opened.trouble());
  try {
    if (file.extension() == ".json")
      if (const json j = read_json_file(file); j.is_object() && j.contains("document"))
        return made_from_report(j, file, types);
    const std::string inside = read_provenance ? read_provenance(file) : "";
    if (const json j = json_or_null(inside); j.is_object() && j.contains("document")) {
      Made made{j.at("document"), {}, {}, {}, {}, give_values(j.value("values", json::object()), types)};
      for (const auto& [node, key] : j.at("keys").items()) made.keys[node] = key;
      if (j.contains("files"))
        for (const auto& f : j.at("files")) {
          made.contents.insert(f.at("content"));
          if (f.contains("node")) made.contents_of[f.at("node")].insert(f.at("content"));
        }
      // The file itself tells no folders, but the report beside it may.
      if (const auto beside = made_by_report_beside(file, types)) made.places = beside->places;
      return made;
    }
    if (const auto made = made_by_report_beside(file, types)) return *made;
  } catch (const json::exception& e) {
    throw Error("usage", "the provenance of '" + file.string() + "' is damaged: " + json_problem(e));
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

// Finds the input files of a document. Provenance in a file names them without folders, a report with paths
// relative to the original output folder, which is the file's folder or one above it.
class InputSearch {
 public:
  // `granted`: folders that the user allows to read.
  InputSearch(const fs::path& folder, const std::vector<std::string>& granted, const Made& made)
      : start_(folder), made_(made) {
    fs::path up = folder;
    for (int k = 0; k < 4; ++k, up = up.parent_path()) folders_.push_back(up);
    for (const auto& g : granted) folders_.push_back(fs::absolute(g).lexically_normal());
  }

  // The first place where all files are those that the node read. If there is none, the first with any files,
  // or else `path` itself, which is absolute.
  fs::path find(const GraphNode& node, const fs::path& path) const {
    const auto known = made_.contents_of.find(node.path);
    const auto& originals = known != made_.contents_of.end() ? known->second : made_.contents;
    const fs::path relative = path.lexically_relative(start_);
    std::vector<fs::path> places;
    for (const fs::path& folder : folders_) places.push_back((folder / relative).lexically_normal());
    for (const fs::path& folder : folders_) places.push_back(folder / path.filename());
    for (const fs::path& file : made_.places)
      if (file.filename() == path.filename()) places.push_back(file);
    std::optional<fs::path> any;
    for (const fs::path& place : places) {
      const auto files = expand_glob(place);
      if (files.empty()) continue;
      if (!any) any = place;
      const auto is_original = [&](const fs::path& file) {
        for (const auto& f : files_opened(*node.type, file))
          if (const auto content = hashes_.hash(f); content && !originals.contains(content->text()))
            return false;
        return true;
      };
      if (std::all_of(files.begin(), files.end(), is_original)) return place;
    }
    return any.value_or(path);
  }

 private:
  fs::path start_;
  std::vector<fs::path> folders_;
  const Made& made_;
  mutable FileHashes hashes_;
};

}  // namespace

Made how_made(const fs::path& file, const ValueTypes& types,
              std::string (*read_provenance)(const fs::path&)) {
  Made made = provenance_of(file, types, read_provenance);
  refuse_subgraphs(made);
  return made;
}

Graph open_made(const Registry& registry, const Made& made, const fs::path& file, const Overrides& overrides,
                const std::vector<std::string>& folders, Diagnostics& found) {
  // No such file exists; messages name it.
  const fs::path document =
      fs::absolute(file).lexically_normal().parent_path() / ("graph in " + file.filename().string());
  Graph graph = load_graph_text(made.document, document, registry, overrides, found);
  const InputSearch search(document.parent_path(), folders, made);
  for (auto& node : graph.nodes)
    for (const auto& p : node.type->parameters)
      if (const auto it = node.parameters.find(p.name); p.kind == ParameterKind::InputPath &&
                                                        it != node.parameters.end() &&
                                                        !is_from_command_line(it->second))
        it->second.value = search.find(node, std::get<std::string>(it->second.value)).string();
  if (!has_errors(found)) require_given_values(graph, file.string());
  return graph;
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
          const auto content = read.granted ? std::nullopt : hashes.hash(f, available_memory());
          read.named = content && made.contents.count(content->text());
          if (read.allowed() || fs::exists(f)) out.push_back(read);  // the run reports a missing file
        }
    }
  return out;
}

}  // namespace terrazzo::cli
