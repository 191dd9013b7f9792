// Writes a graph as a single file, with subgraphs expanded and graph parameters filled in.
#pragma once

#include <string>
#include <vector>

#include "graph/graph.h"

namespace terrazzo {

// Writes the nodes marked in `which` (all if it is empty) in the graph file format. Loading the text yields
// the same nodes with the same paths, each of which may fail by itself if `which` is empty and the graph says
// so. Input paths are written relative to `base`, or absolute if it is empty.
std::string write_graph(const Graph&, const std::vector<bool>& which = {},
                        const std::filesystem::path& base = {});
// The same with the names of the input files alone.
std::string write_graph_without_folders(const Graph&, const std::vector<bool>& which);

}  // namespace terrazzo
