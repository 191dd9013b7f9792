// A graph as YAML.
#include <fmt/format.h>

#include <algorithm>

#include "graph/describe.h"
#include "graph/write_document.h"
#include "graph/write_graph.h"
#include "runtime/python/graph_object.h"

namespace terrazzo::python {
namespace fs = std::filesystem;

void GraphObject::require_savable() const {
  std::vector<std::string> given;
  for (const auto& node : document_.nodes)
    if (is_given_type(node.type)) given.push_back(node.name);
  if (!given.empty())
    throw Error("not-savable",
                fmt::format("a graph file cannot hold the arrays of the nodes {}", fmt::join(given, ", ")),
                "write them to files (value.save) and load these with LoadImage, LoadLabels or LoadMesh");
}

std::string GraphObject::flat_text(const fs::path& folder) {
  require_savable();
  link();
  Graph graph = *session().graph();
  std::erase_if(graph.outputs, [&](const GraphOutput& o) {  // those that were only evaluated
    return inner_outputs_.count(o.name) > 0 || inner_outputs_.count(o.name.substr(0, o.name.rfind('['))) > 0;
  });
  return write_graph(graph, {}, fs::absolute(folder).lexically_normal());
}

std::string GraphObject::text(const fs::path& folder) const {
  require_savable();
  if (!overrides_.set.empty() || !overrides_.wires.empty())
    throw Error("not-savable", "a graph file cannot record changes of nodes inside subgraphs",
                "save it with flat=True, which writes all nodes, or add a parameter to the subgraph's file");
  // Paths that were read from the file are relative to its folder; those set here are absolute.
  const fs::path to = fs::absolute(folder).lexically_normal(), from = opened_.parent_path();
  const auto moved = [&](std::string& path, bool ours) {
    if (path.empty() || path.rfind("${", 0) == 0) return;
    const fs::path p = path;
    if (p.is_absolute() && !ours) return;
    const fs::path near = (p.is_absolute() ? p : from / p).lexically_normal().lexically_relative(to);
    if (!near.empty()) path = near.generic_string();
  };
  RawDocument doc = document_;
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
