#include "runtime/clients/studio/live/written_files.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace terrazzo::studio {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::vector<std::string> paths_of(const GraphNode& node, const NodeStates& states) {
  std::vector<std::string> out;
  if (const auto state = states.find(node.path); state != states.end())
    for (const auto& f : state->second.result.files) out.push_back(f.path);
  if (!out.empty()) return out;
  for (const auto& p : node.type->parameters)
    if (const auto it = node.parameters.find(p.name);
        p.kind == ParameterKind::OutputPath && it != node.parameters.end())
      out.push_back(std::get<std::string>(it->second.value));
  return out;
}

}  // namespace

json written_files(const Graph& graph, const NodeStates& states, const fs::path& folder) {
  json out = json::array();
  for (const auto& node : graph.nodes) {
    if (!node.type->writes_files) continue;
    for (const auto& path : paths_of(node, states)) {
      json entry = {{"node", node.path}, {"path", path}};
      std::error_code error;
      if (const auto bytes = fs::file_size(folder / path, error); !error) entry["bytes"] = bytes;
      out.push_back(std::move(entry));
    }
  }
  return out;
}

fs::path written_file(const Graph& graph, const NodeStates& states, const fs::path& folder,
                      const std::string& path) {
  const json all = written_files(graph, states, folder);
  const bool listed = std::ranges::any_of(all, [&](const json& f) { return f.at("path") == path; });
  std::error_code error;
  const fs::path root = fs::canonical(folder, error), file = fs::canonical(folder / path, error);
  const bool inside = !error && std::ranges::mismatch(root, file).in1 == root.end();
  if (!listed || !inside || !fs::is_regular_file(file, error))
    throw Error("no-file", "the graph wrote no file '" + path + "'", "write it first");
  return file;
}

}  // namespace terrazzo::studio
