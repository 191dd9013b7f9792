#include "runtime/run_result.h"

#include "graph/diagnostic.h"

namespace terrazzo {

const char* name_of(Status s) {
  switch (s) {
    case Status::Unneeded:
      return "unneeded";
    case Status::Computed:
      return "computed";
    case Status::Memory:
      return "memory";
    case Status::Disk:
      return "disk";
    case Status::Failed:
      return "failed";
    case Status::Skipped:
      return "skipped";
    case Status::Cancelled:
      return "cancelled";
  }
  return "?";
}

bool RunResult::failed() const {
  for (const auto& n : nodes)
    if (n.status == Status::Failed) return true;
  return false;
}

bool RunResult::cancelled() const {
  for (const auto& n : nodes)
    if (n.status == Status::Cancelled) return true;
  return false;
}

std::vector<int> target_nodes(const Graph& graph, const std::vector<std::string>& targets) {
  std::vector<int> out;
  for (const auto& t : targets) {
    const int node = graph.find(t);
    out.push_back(node >= 0 ? node : graph.wire_to(t).node);
  }
  return out;
}

std::vector<bool> needed_nodes(const Graph& graph, const std::vector<int>& targets) {
  std::vector<bool> needed(graph.nodes.size(), false);
  for (const int t : targets) needed[static_cast<std::size_t>(t)] = true;
  for (std::size_t i = graph.nodes.size(); i-- > 0;)  // consumers come after their sources
    if (needed[i])
      for (const auto& [port, wires] : graph.nodes[i].inputs)
        for (const auto& w : wires) needed[static_cast<std::size_t>(w.node)] = true;
  return needed;
}

Diagnostic placed(const Error& e, const GraphNode& node) {
  Diagnostic d = e.diagnostic();
  if (!d.node.empty()) return d;  // already placed, by the source that was recomputed
  d.node = node.path;
  if (d.place.file.empty()) {
    const auto it = node.parameters.find(d.parameter);
    d.place = it != node.parameters.end() ? it->second.place : node.place;
    if (d.place.file == node.place.file) d.through = node.through;
  }
  return d;
}

}  // namespace terrazzo
