// The provenance of a file that a node writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/evaluate.h"

namespace terrazzo {

// The caller's provenance, plus the action keys of all nodes upstream of `node`, the content hashes of their
// input files, and a graph that reproduces the result.
std::string file_provenance(const Graph&, int node, const RunResult&, const RunOptions&);

// The input files of every node of the graph, needed or not, and the graph's own file.
std::vector<std::filesystem::path> all_input_files(const Graph&);

}  // namespace terrazzo
