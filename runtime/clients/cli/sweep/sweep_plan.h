// Plans a sweep: checks every point before the first one runs, and finds what all points share.
#pragma once

#include <optional>

#include "runtime/clients/cli/options.h"
#include "runtime/sweep/sweep_file.h"

namespace terrazzo::cli {

struct SweepPlan {
  SweepFile file;
  // Computing time in seconds, from the history of this cache; 0 if unknown.
  double shared_seconds = 0;  // of all shared nodes together
  double point_seconds = 0;   // of the other nodes of one point
};
// Loads the graph of each point in turn. If one has errors, prints them and returns nothing.
std::optional<SweepPlan> plan_sweep(const Program&, Session&, const GraphOptions&, SweepPoints);

// One plan for each round of the session's graph, whose repeated nodes are computed on several machines.
// Empty if no node is repeated. Throws Error "unknown-node" or "unknown-port" for a wrong target.
std::vector<SweepPlan> plan_rounds(Session&, const GraphOptions&);

}  // namespace terrazzo::cli
