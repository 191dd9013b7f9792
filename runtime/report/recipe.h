// What determines a node's own computation in a graph.
#pragma once

#include <string>

#include "graph/graph.h"

namespace terrazzo {

// A text of everything in the graph that determines a node's own computation. Equal texts mean equal
// computations, if the sources are equal too.
std::string recipe(const Graph&, const GraphNode&);

}  // namespace terrazzo
