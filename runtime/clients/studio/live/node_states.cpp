#include "runtime/clients/studio/live/node_states.h"

#include <nlohmann/json.hpp>

namespace terrazzo::studio {
using nlohmann::json;

json json_of(const Diagnostic& d) {
  const char* const words[] = {"error", "warning", "note"};
  json through = json::array();
  for (const auto& p : d.through) through.push_back({{"file", p.file}, {"line", p.line}});
  return {{"severity", words[static_cast<int>(d.severity)]},
          {"code", d.code},
          {"message", d.message},
          {"hint", d.hint},
          {"file", d.place.file},
          {"line", d.place.line},
          {"column", d.place.column},
          {"node", d.node},
          {"parameter", d.parameter},
          {"through", through}};
}

json json_of(const OutputRecord& o) {
  return {{"type", o.type}, {"hash", o.content.text()}, {"bytes", o.bytes}};
}

json json_of(const NodeState& s) {
  json outputs = json::object();
  json files = json::array();
  json previews = json::object();
  for (const auto& [port, o] : s.result.outputs) outputs[port] = json_of(o);
  for (const auto& f : s.result.files) files.push_back(f.path);
  for (const auto& [port, p] : s.previews)
    previews[port] = {{"type", p.value.type().name}, {"number", p.number}};
  json out = {{"type", s.type},
              {"state", s.state},
              {"progress", s.progress},
              {"note", s.note},
              {"seconds", s.seconds},
              {"expected", s.expected},
              {"reasons", s.reasons},
              {"outputs", outputs},
              {"metrics", s.result.metrics},
              {"warnings", s.result.warnings},
              {"files", files},
              {"previews", previews}};
  if (s.state == "running")
    out["elapsed"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - s.started).count();
  if (s.result.error) out["error"] = json_of(*s.result.error);
  return out;
}

void apply_plan(NodeStates& states, const Graph& graph, const Plan& plan, bool running, bool changed) {
  NodeStates now;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const std::string& path = graph.nodes[i].path;
    const auto before = states.find(path);
    NodeState s = before == states.end() ? NodeState{} : std::move(before->second);
    const Plan::Node& p = plan.nodes[i];
    s.type = graph.nodes[i].type->name;
    s.expected = p.seconds;
    s.progress = 0;
    s.note.clear();
    if (p.step == Plan::Step::Cached) {
      s.state = "cached";
      s.seconds = p.seconds;
      s.previews.clear();
    } else if (p.step == Plan::Step::Unneeded) {
      if (!changed && before != states.end()) {
        now[path] = std::move(s);
        continue;
      }
      s.state = "stale";
      s.reasons.clear();
      s.previews.clear();
    } else {
      s.state = running ? "waiting" : "stale";
      s.reasons = p.reasons;
      s.result.error.reset();
      if (!running) s.previews.clear();
    }
    now[path] = std::move(s);
  }
  states = std::move(now);
}

}  // namespace terrazzo::studio
