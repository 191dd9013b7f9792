#include "runtime/report/recipe.h"

namespace terrazzo {

std::string recipe(const Graph& graph, const GraphNode& node) {
  std::string out = node.type->name;
  for (const auto& p : node.type->parameters) {
    const auto it = node.parameters.find(p.name);
    out += "\n" + p.name + "=";
    if (it != node.parameters.end() || p.value)
      out += canonical(it != node.parameters.end() ? it->second.value : *p.value);
  }
  for (const auto& [port, wires] : node.inputs)
    for (const auto& w : wires) out += "\n" + port + "<" + graph.nodes[w.node].path + "." + w.port;
  return out;
}

}  // namespace terrazzo
