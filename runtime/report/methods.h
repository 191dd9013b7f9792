// A paragraph on the methods of a graph, for a paper, with its sources.
#pragma once

#include <string>
#include <vector>

#include "graph/graph.h"
#include "graph/registry.h"

namespace terrazzo {

// What the nodes above `targets` (empty: the default ones) do, by their declarations: versions, seeds,
// settings other than the defaults, and numbered sources, which a list below the paragraph names. Nodes that
// write files are left out. Nodes of one type with equal settings share a sentence. `version`: of the
// program.
std::string methods_text(const Graph&, const std::vector<int>& targets, const Registry&,
                         const std::string& version);

}  // namespace terrazzo
