// Provenance: what a written file says of how it was made.
#pragma once

#include <filesystem>
#include <string>

#include "graph/graph.h"

namespace terrazzo {

inline constexpr const char* program_version = "0.1.0";

// A JSON object: program, graph, overrides, versions of the node types and parameters. The evaluator adds,
// for each file, the keys of the nodes upstream and a graph that makes the file ("document").
std::string provenance(const Graph&, const Overrides&);

}  // namespace terrazzo
