#include "runtime/clients/cli/write_value.h"

#include <deque>
#include <optional>
#include <set>

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

const GraphNode& at(const Graph& graph, int node) { return graph.nodes[node]; }

const std::string& type_of(const Graph& graph, const Wire& w) {
  return at(graph, w.node).type->find_output(w.port)->types[0];
}

// The nearest wire upstream of `from` that carries a value of this type.
std::optional<Wire> nearest_upstream(const Graph& graph, const Wire& from, const std::string& type) {
  std::deque<int> next{from.node};
  std::vector<bool> seen(graph.nodes.size(), false);
  while (!next.empty()) {
    const int node = next.front();
    next.pop_front();
    for (const auto& [name, wires] : at(graph, node).inputs)
      for (const auto& w : wires) {
        if (type_of(graph, w) == type) return w;
        if (!seen[w.node]) next.push_back(w.node);
        seen[w.node] = true;
      }
  }
  return {};
}

}  // namespace

int append_writer(const Registry& registry, Graph& graph, const Wire& wire, const fs::path& file) {
  for (const NodeType* type : registry.all()) {
    if (!type->writes_files || !type->find_parameter("path")) continue;
    const Port* port = nullptr;
    for (const auto& p : type->inputs)
      if (p.accepts(type_of(graph, wire)) && (!port || port->types.empty())) port = &p;
    if (!port) continue;
    GraphNode node;
    node.path = "(write)";
    node.type = type;
    node.place = {"command line (-o)", 0, 0};
    node.inputs[port->name] = {wire};
    // Scenes store particles as mesh instances, and spheres have their volumes; the value contains no meshes.
    const std::set<std::string> scenes = {".glb", ".usda", ".xml", ".pbrt", ".lmp", ".obj", ".ply", ".stl"};
    if (type_of(graph, wire) == "Particles" && scenes.count(file.extension().string()))
      if (const auto shapes = nearest_upstream(graph, wire, "Shapes"))
        for (const auto& p : type->inputs)
          if (!p.types.empty() && p.accepts("Shapes")) node.inputs[p.name] = {*shapes};
    node.parameters["path"] = {ParameterValue(file.filename().string()), node.place, file.string()};
    graph.nodes.push_back(std::move(node));
    return static_cast<int>(graph.nodes.size()) - 1;
  }
  throw Error("usage", "no node type writes values of type " + type_of(graph, wire) + " to files");
}

}  // namespace terrazzo::cli
