// A graph as YAML.
#include <fmt/format.h>

#include <algorithm>

#include "graph/describe.h"
#include "graph/document/write_document.h"
#include "graph/document/write_graph.h"
#include "runtime/clients/python/edits.h"
#include "runtime/clients/python/graph_object.h"
#include "runtime/files/protected_files.h"

namespace terrazzo::python {
namespace fs = std::filesystem;

Value GraphObject::given_value(const std::string& node) const {
  const RawNode* raw = find(node);
  if (!raw || !is_given_type(raw->type))
    throw Error("unknown-node", fmt::format("the node '{}' holds no value", node));
  return given_.at(raw->params[0].second.written.items[0])->value;
}

// The document with the stand-ins in place of the nodes that hold values. Wires of the overrides follow.
RawDocument GraphObject::savable(const StandIns& stand_ins, Overrides& overrides) const {
  RawDocument doc = document_;
  std::vector<std::string> given;
  std::map<std::string, std::string> outputs;  // former ones, with those of the stand-ins
  const Place place = callers_place();
  for (auto& node : doc.nodes) {
    if (!is_given_type(node.type)) continue;
    const auto it = stand_ins.find(node.name);
    if (it == stand_ins.end()) {
      given.push_back(node.name);
      continue;
    }
    const StandIn& s = it->second;
    outputs[node.name + ".value"] = node.name + "." + s.output;
    node.type = s.type;
    node.params.clear();
    const NodeType* type = registry().find(s.type);
    for (const auto& [name, value] : s.params) {
      RawValue raw{written_value(value), place};
      if (const Parameter* p = type ? type->find_parameter(name) : nullptr) make_absolute(*p, raw.written);
      node.params.emplace_back(name, std::move(raw));
    }
  }
  if (!given.empty())
    throw Error("not-savable",
                fmt::format("a graph file cannot hold the arrays of the nodes {}", fmt::join(given, ", ")),
                "save(FILE, arrays=FOLDER) writes them to files and loads these");
  const auto follow = [&](std::string& reference) {
    if (const auto it = outputs.find(reference); it != outputs.end()) reference = it->second;
  };
  for (auto& node : doc.nodes)
    for (auto& [port, wires] : node.inputs)
      for (auto& w : wires) follow(w.text);
  for (auto* list : {&doc.outputs, &doc.inputs})
    for (auto& [port, w] : *list) follow(w.text);
  for (auto& [input, sources] : overrides.wires)
    for (auto& source : sources) follow(source);
  return doc;
}

void GraphObject::require_other_file(const fs::path& file) const {
  FileSet own;
  if (!opened_.empty()) own.add(opened_);
  Diagnostics ignored;
  if (!own.find(file))
    ProtectedFiles(link_document(document_, registry(), overrides_, ignored)).require_other(file);
}

std::string GraphObject::flat_text(const fs::path& folder, const StandIns& stand_ins) const {
  Overrides overrides = overrides_;
  RawDocument doc = savable(stand_ins, overrides);
  Diagnostics found;
  const Graph graph = link_document(std::move(doc), registry(), overrides, found);
  if (has_errors(found)) raise(found);
  return write_graph(graph, {}, fs::absolute(folder).lexically_normal());
}

std::string GraphObject::text(const fs::path& folder, const StandIns& stand_ins) const {
  Overrides ignored;
  RawDocument doc = savable(stand_ins, ignored);
  if (!overrides_.set.empty() || !overrides_.wires.empty())
    throw Error("not-savable", "a graph file cannot record changes of nodes inside subgraphs",
                "save it with flat=True, which writes all nodes, or add a parameter to the subgraph's file");
  // Paths that were read from the file are relative to its folder; those set here are absolute.
  const fs::path to = fs::absolute(folder).lexically_normal();
  const fs::path from = opened_.parent_path();
  const auto moved = [&](std::string& path, bool ours) {
    if (path.empty() || path.rfind("${", 0) == 0) return;
    const fs::path p = path;
    if (p.is_absolute() && !ours) return;
    const fs::path near = (p.is_absolute() ? p : from / p).lexically_normal().lexically_relative(to);
    if (!near.empty()) path = near.generic_string();
  };
  const auto ours = [&](const Place& place) { return opened_.empty() || place.file != opened_.string(); };
  const bool same_folder = !from.empty() && from == to;
  const auto move_value = [&](const Parameter& p, RawValue& v) {
    if (p.kind != ParameterKind::InputPath || v.written.is_list || v.written.items.empty()) return;
    const std::string& path = v.written.items[0];
    if (std::find(p.keywords.begin(), p.keywords.end(), path) != p.keywords.end()) return;
    if (ours(v.place) || !same_folder) moved(v.written.items[0], ours(v.place));
  };
  for (auto& p : doc.parameters) move_value(p.declaration, p.value);
  for (auto& node : doc.nodes) {
    std::shared_ptr<const NodeType> sub;
    const NodeType* type = registry().find(node.type);
    if (!type) type = registry().find_former(node.type);
    if (!node.graph.empty()) {
      Diagnostics ignored;
      const Graph graph = load_graph((from / node.graph).lexically_normal(), registry(), {}, ignored);
      sub = std::make_shared<NodeType>(describe_graph(graph));
      type = sub.get();
      if (ours(node.kind_place) || !same_folder) moved(node.graph, ours(node.kind_place));
    }
    for (auto& [name, value] : node.params)
      if (const Parameter* p = type ? type->find_parameter(name) : nullptr) {
        move_value(*p, value);
        for (auto& [variable, values] : node.each)  // files that the node is repeated for
          if (p->kind == ParameterKind::InputPath && value.written.text() == "${" + variable + "}" &&
              (ours(values.place) || !same_folder))
            for (auto& path : values.written.items) moved(path, ours(values.place));
      }
  }
  return write_document(doc, original_);
}

}  // namespace terrazzo::python
