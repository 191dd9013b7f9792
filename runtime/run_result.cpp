#include "runtime/run_result.h"

#include <unordered_map>

#include "graph/diagnostic.h"
#include "graph/text/element_name.h"

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

Diagnostics RunResult::errors() const {
  Diagnostics out;
  for (const auto& n : nodes)
    if (n.error && (without_result || !n.tolerated)) {
      out.push_back(*n.error);
      out.back().severity = Severity::Error;
    }
  return out;
}

bool RunResult::cancelled() const {
  for (const auto& n : nodes)
    if (n.status == Status::Cancelled) return true;
  return false;
}

std::vector<int> target_nodes(const Graph& graph, const std::vector<std::string>& targets) {
  std::unordered_map<std::string, int> by_path;
  if (!targets.empty())
    for (std::size_t i = 0; i < graph.nodes.size(); ++i)
      by_path.emplace(graph.nodes[i].path, static_cast<int>(i));
  std::vector<int> out;
  for (const auto& t : targets) {
    if (const auto node = by_path.find(t); node != by_path.end()) {
      out.push_back(node->second);
      continue;
    }
    // The name of a repeated node or of a list stands for all elements.
    const auto before = out.size();
    for (const auto& o : graph.outputs)
      if (is_named(o.name, t)) out.push_back(o.wire.node);
    if (out.size() == before) {
      const std::string path = t.substr(0, find_port_dot(t));
      for (std::size_t i = 0; i < graph.nodes.size(); ++i)
        if (is_named(graph.nodes[i].path, path)) {
          if (path != t && out.size() == before)
            graph.wire_to(graph.nodes[i].path + t.substr(path.size()));  // checks the port
          out.push_back(i);
        }
      // For a bypassed node, what its readers read.
      for (const auto& [bypassed, passed] : graph.bypassed)
        if (is_named(bypassed, path))
          for (const auto& [port, wire] : passed)
            if (path == t || t.substr(path.size() + 1) == port) out.push_back(wire.node);
    }
    if (out.size() == before) out.push_back(graph.wire_to(t).node);
  }
  return out;
}

std::vector<bool> needed_nodes(const Graph& graph, const std::vector<int>& targets) {
  std::vector<bool> needed(graph.nodes.size(), false);
  for (const int t : targets) needed[t] = true;
  for (std::size_t i = graph.nodes.size(); i-- > 0;)  // consumers come after their sources
    if (needed[i])
      for (const auto& [port, wires] : graph.nodes[i].inputs)
        for (const auto& w : wires) needed[w.node] = true;
  return needed;
}

bool is_left_out(const Graph& graph, const RunResult& run, const GraphNode& reader, const Wire& wire) {
  const std::string& part = graph.nodes[wire.node].may_fail;
  return run.nodes[wire.node].tolerated && (part.empty() || !reader.path.starts_with(part + "/"));
}

std::vector<bool> used_nodes(const Graph& graph, const RunResult& run, int node) {
  std::vector<bool> used(graph.nodes.size(), false);
  used[node] = true;
  for (std::size_t i = node + 1; i-- > 0;)  // consumers come after their sources
    if (used[i])
      for (const auto& [port, wires] : graph.nodes[i].inputs)
        for (const auto& w : wires)
          if (!is_left_out(graph, run, graph.nodes[i], w)) used[w.node] = true;
  return used;
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
