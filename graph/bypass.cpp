// Bypassed nodes: the linked graph is the one without them.
#include <fmt/format.h>

#include <algorithm>

#include "graph/linker.h"

namespace terrazzo {

void Linker::remove_bypassed() {
  if (bypassed_.empty()) return;
  const std::vector<GraphNode> nodes = std::move(graph_.nodes);
  graph_.nodes.clear();
  std::vector<int> place(nodes.size(), -1);
  const auto type_of = [&](const Wire& w) { return nodes[w.node].type->find_output(w.port)->types.front(); };
  // The wire in the graph without bypassed nodes, or none if a bypassed source passes nothing through.
  const auto follow = [&](const Wire& w) -> std::optional<Wire> {
    const GraphNode& source = nodes[w.node];
    const auto bypassed = graph_.bypassed.find(source.path);
    if (bypassed == graph_.bypassed.end()) return Wire{place[w.node], w.port, w.place};
    const auto passed = bypassed->second.find(w.port);
    if (passed == bypassed->second.end()) return {};
    return Wire{passed->second.node, passed->second.port, w.place};
  };
  const auto reconnect = [&](Wire& w, const std::string& reader) {
    if (const auto there = follow(w)) {
      w = *there;
      return true;
    }
    const GraphNode& source = nodes[w.node];
    fail("cannot-bypass",
         fmt::format("'{}' is bypassed, and none of its connected inputs is {}, like its output '{}'",
                     source.path, type_of(w), w.port),
         w.place, "connect another output here, or remove `bypass`", reader);
    return false;
  };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    GraphNode node = nodes[i];
    if (!bypassed_.count(node.path)) {
      for (auto& [port, wires] : node.inputs)
        std::erase_if(wires, [&](Wire& w) { return !reconnect(w, node.path); });
      place[i] = graph_.nodes.size();
      graph_.nodes.push_back(std::move(node));
      continue;
    }
    std::map<std::string, Wire> passed;
    for (const Port& output : node.type->outputs)
      for (const Port& input : node.type->inputs)
        if (const auto wires = node.inputs.find(input.name); wires != node.inputs.end())
          for (const Wire& w : wires->second)
            if (type_of(w) == output.types.front() && !passed.count(output.name))
              if (const auto there = follow(w)) passed.emplace(output.name, *there);
    graph_.bypassed.emplace(node.path, std::move(passed));
  }
  std::erase_if(graph_.outputs, [&](GraphOutput& o) { return !reconnect(o.wire, {}); });
}

}  // namespace terrazzo
