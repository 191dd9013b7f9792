#include "runtime/clients/studio/live/document_json.h"

#include <nlohmann/json.hpp>

#include "graph/describe.h"
#include "graph/text/element_name.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

json value_json(const RawValue& v) {
  json out = {{"line", v.place.line}};
  if (v.written.is_list)
    out["value"] = v.written.items;
  else
    out["value"] = v.written.items.empty() ? "" : v.written.items.front();
  return out;
}

// The node inside of subgraphs that makes an output: {path, port}, or null if there is none.
json inner_output(const RawDocument& doc, const std::string& prefix, const std::string& reference,
                  int depth) {
  const auto dot = find_port_dot(reference);
  const std::string name = written_node(reference);
  for (const auto& node : doc.nodes) {
    if (node.name != name) continue;
    if (node.graph.empty())
      return {{"path", prefix + name}, {"port", dot == std::string::npos ? "" : reference.substr(dot + 1)}};
    if (depth >= 32 || dot == std::string::npos) return nullptr;
    Diagnostics found;
    const fs::path file = (doc.file.parent_path() / node.graph).lexically_normal();
    const auto text = read_graph_text(file, found);
    if (!text) return nullptr;
    const RawDocument inner = read_document(*text, file, found);
    for (const auto& [port, wire] : inner.outputs)
      if (port == reference.substr(dot + 1))
        return inner_output(inner, prefix + name + "/", wire.text, depth + 1);
  }
  return nullptr;
}

void add_subgraph(json& out, const RawDocument& doc, const RawNode& node, const Registry& registry) {
  Diagnostics found;
  const fs::path file = (doc.file.parent_path() / node.graph).lexically_normal();
  const NodeType type = describe_graph(load_graph(file, registry, {}, found));
  out["declaration"] = describe_json(type);
  json inner = json::object();
  for (const auto& port : type.outputs)
    inner[port.name] = inner_output(doc, "", node.name + "." + port.name, 0);
  out["inner"] = inner;
}

}  // namespace

void add_bypassed(json& document, const Graph& graph, const std::string& prefix) {
  for (auto& n : document["nodes"]) {
    if (n["bypass"] != true) continue;
    json inner = json::object();
    for (const auto& [path, passed] : graph.bypassed) {
      if (!is_named(path, prefix + n["name"].get<std::string>())) continue;
      for (const auto& [port, wire] : passed)
        if (!inner.contains(port))  // the first element's
          inner[port] = {{"path", graph.nodes[wire.node].path}, {"port", wire.port}};
    }
    n["inner"] = inner;
  }
}

void add_file(json& document, const Document& d) {
  document["file"] = d.file().string();
  document["text"] = d.text();
  document["saved"] = d.saved();
  document["read_only"] = d.read_only();
  document["can_undo"] = d.can_undo();
  document["can_redo"] = d.can_redo();
  document["arrangement"] = arrangement_json(d.arrangement());
}

json json_of(const RawDocument& doc, const Registry& registry, bool drawn) {
  json nodes = json::array();
  json outputs = json::array();
  json parameters = json::array();
  for (const auto& node : doc.nodes) {
    if (!drawn) break;
    json params = json::object();
    json inputs = json::object();
    for (const auto& [name, value] : node.params) params[name] = value_json(value);
    for (const auto& [port, wires] : node.inputs) {
      json list = json::array();
      for (const auto& w : wires) list.push_back(w.text);
      inputs[port] = list;
    }
    json n = {{"name", node.name},       {"type", node.type}, {"graph", node.graph}, {"doc", node.doc},
              {"line", node.place.line}, {"params", params},  {"inputs", inputs},    {"bypass", node.bypass}};
    for (const auto& [name, value] : node.each) n["each"][name] = value_json(value);
    if (!node.graph.empty()) add_subgraph(n, doc, node, registry);
    nodes.push_back(std::move(n));
  }
  for (const auto& [name, wire] : doc.outputs)
    if (drawn) outputs.push_back({{"name", name}, {"wire", wire.text}, {"line", wire.place.line}});
  for (const auto& p : doc.parameters)
    parameters.push_back({{"name", p.declaration.name},
                          {"kind", name_of(p.declaration.kind)},
                          {"doc", p.declaration.doc},
                          {"unit", p.declaration.unit},
                          {"choices", p.declaration.choices},
                          {"keywords", p.declaration.keywords},
                          {"line", p.place.line},
                          {"value", value_json(p.value)["value"]}});
  return {{"name", doc.name},
          {"doc", doc.doc},
          {"nodes", nodes},
          {"outputs", outputs},
          {"parameters", parameters}};
}

}  // namespace terrazzo::studio
