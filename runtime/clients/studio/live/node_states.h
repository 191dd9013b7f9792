// What is known about the evaluation of each node: state, progress, times, reasons, results.
#pragma once

#include <chrono>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "runtime/report/explain.h"

namespace terrazzo::studio {

// A preliminary value of an output.
struct Preview {
  std::uint64_t number;  // of all previews of the session
  Value value;
};

struct NodeState {
  std::string type;  // of the node
  // "cached", "stale", "waiting", "running", "computed", "failed", "skipped", "canceled"
  std::string state = "stale";
  double progress = 0;
  std::string note;
  double seconds = 0;                // of the computation, now or when it was cached
  double expected = 0;               // of the last computation; 0 if unknown
  std::vector<std::string> reasons;  // why it runs or ran
  NodeResult result;                 // of the last run; of an earlier graph while the state is not final
  // By port. While the node waits and runs; the last ones of an earlier run stay until there are new ones.
  std::map<std::string, Preview> previews = {};
  std::chrono::steady_clock::time_point started{};  // if it runs
  std::chrono::steady_clock::time_point told{};     // when progress was last reported
  std::size_t told_state = 0;  // hash of what was last reported otherwise; 0: something else
};

// By path, as in Graph::nodes.
using NodeStates = std::map<std::string, NodeState>;

nlohmann::json json_of(const NodeState&);
nlohmann::json json_of(const Diagnostic&);
nlohmann::json json_of(const OutputRecord&);

// The states of a plan. Keeps what earlier runs found, and of nodes that the plan does not need also their
// states unless the graph has `changed`.
void apply_plan(NodeStates&, const Graph&, const Plan&, bool running, bool changed = true);

}  // namespace terrazzo::studio
