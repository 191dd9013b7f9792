// The provenance of a file that a node writes.
#pragma once

#include <string>

#include "runtime/evaluate.h"

namespace terrazzo {

// The caller's provenance, plus the action keys of all nodes upstream of `node`, the content hashes of their
// input files, and a graph that reproduces the result.
std::string file_provenance(const Graph&, int node, const RunResult&, const RunOptions&);

}  // namespace terrazzo
