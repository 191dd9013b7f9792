#include "runtime/report/history.h"

#include <nlohmann/json.hpp>

#include "runtime/cache/cache_folder.h"
#include "runtime/files.h"
#include "runtime/files/json_input.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

Hash name_of(const Graph& graph, const GraphNode& node) {
  return hash_of(fs::absolute(graph.file).lexically_normal().string() + "\n" + node.path);
}

}  // namespace

std::optional<HistoryEntry> History::find(const Graph& graph, const GraphNode& node) const {
  if (folder_.empty()) return {};
  const auto text = read_file(cache_entry(folder_, "history", name_of(graph, node)));
  if (!text) return {};
  try {
    const json j = parse_json(*text);
    HistoryEntry e;
    e.key = j.at("key");
    e.type = j.at("type");
    e.version = j.at("version");
    j.at("parameters").get_to(e.parameters);
    j.at("files").get_to(e.files);
    j.at("inputs").get_to(e.inputs);
    return e;
  } catch (const json::exception&) {
    return {};  // damaged: treat the node as never computed
  } catch (const Error&) {
    return {};
  }
}

HistoryEntry history_entry(const GraphNode& node, const std::vector<NodeResult>& results, FileHashes& hashes,
                           const Hash& key) {
  HistoryEntry e;
  e.key = key.text();
  e.type = node.type->name;
  e.version = node.type->version;
  for (const auto& p : node.type->parameters) {
    const auto it = node.parameters.find(p.name);
    if (it != node.parameters.end())
      e.parameters[p.name] = written(it->second.value);
    else if (p.value)
      e.parameters[p.name] = written(*p.value);
  }
  try {
    for (const auto& [name, list] : input_files(node, hashes).hashes)
      for (const auto& h : list) e.files[name].push_back(h.text());
  } catch (const Error&) {
    // Leave a missing file out, so that it counts as changed.
  }
  for (const auto& [port, wires] : node.inputs)
    for (const auto& w : wires) {
      const auto& outputs = results[w.node].outputs;
      const auto it = outputs.find(w.port);
      e.inputs[port].push_back(it == outputs.end() ? "" : it->second.content.text());
    }
  return e;
}

void History::record(const Graph& graph, const RunResult& run, FileHashes& hashes) const {
  if (folder_.empty()) return;
  std::int64_t grown = 0;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const Status s = run.nodes[i].status;
    if (s != Status::Computed && s != Status::Disk && s != Status::Memory) continue;
    const HistoryEntry e = history_entry(graph.nodes[i], run.nodes, hashes, run.nodes[i].record);
    const json j = {{"key", e.key},         {"type", e.type},
                    {"version", e.version}, {"parameters", e.parameters},
                    {"files", e.files},     {"inputs", e.inputs}};
    const std::string text = json_text(j);
    const Hash name = name_of(graph, graph.nodes[i]);
    if (read_file(cache_entry(folder_, "history", name)) != text) try {
        grown += write_cache_entry(folder_, "history", name, text);
      } catch (const Error&) {
        break;  // only explanations are lost, not results
      }
  }
  if (grown != 0) CacheUsage(folder_).add(grown);
}

}  // namespace terrazzo
