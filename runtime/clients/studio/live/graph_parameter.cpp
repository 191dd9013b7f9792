#include "runtime/clients/studio/live/graph_parameter.h"

#include <algorithm>
#include <cmath>

#include "graph/describe.h"
#include "graph/document/patch_yaml.h"
#include "graph/document/yaml_text.h"
#include "graph/graph.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

std::string declaration(const Parameter& p, const WrittenValue& value) {
  // What a node writes is named by text.
  std::string out = std::string("{type: ") +
                    (p.kind == ParameterKind::OutputPath ? "text" : name_of(p.kind)) +
                    ", default: " + yaml_value(value);
  if (!p.doc.empty()) out += ", doc: " + yaml_word(p.doc);
  if (!p.unit.empty()) out += ", unit: " + yaml_word(p.unit);
  if (std::isfinite(p.min)) out += ", min: " + written(p.min);
  if (std::isfinite(p.max)) out += ", max: " + written(p.max);
  if (!p.choices.empty()) out += ", choices: " + yaml_list(p.choices);
  if (!p.keywords.empty()) out += ", keywords: " + yaml_list(p.keywords);
  return out + "}";
}

// The value that the node has, as written, or else the default.
WrittenValue value_of(const RawNode& node, const Parameter& p) {
  for (const auto& [name, value] : node.params)
    if (name == p.name) {
      for (const std::string& item : value.written.items)
        if (item.find("${") != std::string::npos)
          throw Error("cannot-edit", "'" + p.name + "' reads a parameter of the graph already",
                      "give it its own value first");
      return value.written;
    }
  if (!p.value) throw Error("cannot-edit", "'" + p.name + "' has no value", "set it first");
  return read_written(written(*p.value));
}

std::string free_name(const RawDocument& doc, const std::string& node, const std::string& parameter) {
  const auto taken = [&](const std::string& name) {
    return std::ranges::any_of(doc.parameters, [&](const auto& p) { return p.declaration.name == name; });
  };
  if (!taken(parameter)) return parameter;
  std::string name = node + "_" + parameter;
  for (int k = 2; taken(name); ++k) name = node + "_" + parameter + "_" + std::to_string(k);
  return name;
}

}  // namespace

NewGraphParameter with_graph_parameter(const ReadGraph& graph, const fs::path& file, const Registry& registry,
                                       const std::string& node, const std::string& parameter) {
  const RawDocument& doc = graph.document;
  const auto at = std::ranges::find(doc.nodes, node, &RawNode::name);
  if (at == doc.nodes.end()) throw Error("unknown-node", "there is no node '" + node + "'");
  NodeType subgraph("", 0);
  const NodeType* type = at->graph.empty() ? registry.find(at->type) : &subgraph;
  Diagnostics ignored;
  if (!at->graph.empty())
    subgraph = describe_graph(
        load_graph((file.parent_path() / at->graph).lexically_normal(), registry, {}, ignored));
  const Parameter* p = type ? type->find_parameter(parameter) : nullptr;
  if (!p) throw Error("unknown-parameter", "'" + node + "' has no parameter '" + parameter + "'");
  const std::string name = free_name(doc, node, parameter);
  const auto text = set_yaml_entry(graph.text, {"parameters", name}, declaration(*p, value_of(*at, *p)));
  if (!text) throw Error("cannot-edit", "the text has no place for a parameter", "add it as text");
  return {name, edit_document(*text, file,
                              {.kind = Edit::Kind::SetParameter,
                               .node = node,
                               .name = parameter,
                               .value = {false, {"${" + name + "}"}, {}}})};
}

}  // namespace terrazzo::studio
