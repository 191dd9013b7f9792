// Provenance: how a file was made, stored in the file.
#pragma once

#include <filesystem>
#include <string>

#include "graph/graph.h"

namespace terrazzo {

extern const char* const program_version;  // "0.2.0", from CMakeLists.txt

// A JSON object with program, graph, overrides, node type versions and parameters. For each file, the
// evaluator adds the action keys of the upstream nodes ("keys"), their input files ("files") and a graph that
// makes the file ("document"). Input files are named without their folders.
std::string provenance(const Graph&, const Overrides&);

}  // namespace terrazzo
