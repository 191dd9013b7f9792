// A graph as one file again: subgraphs unfolded, parameters filled in.
#pragma once

#include <string>
#include <vector>

#include "graph/graph.h"

namespace terrazzo {

// The nodes marked in `which` (all where it is empty), in the format of graph files. Loading it gives the
// same nodes under the same paths. Paths of files that are read are written relative to `base`, absolute
// without one.
std::string write_graph(const Graph&, const std::vector<bool>& which = {},
                        const std::filesystem::path& base = {});

}  // namespace terrazzo
