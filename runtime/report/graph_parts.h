// Divides a graph with repeated nodes into parts that several machines can compute.
#pragma once

#include <string>
#include <vector>

#include "graph/graph.h"

namespace terrazzo {

// Elements of repeated nodes that one machine computes together, such as "solid[3]" and "measure[3]".
struct GraphPart {
  std::string name;                  // of its last element: "measure[3]" or "field[wood]"
  std::vector<std::string> targets;  // nodes whose results others need
};

// Parts that need nothing from each other.
struct GraphRound {
  std::vector<GraphPart> parts;
  std::vector<std::string> shared;  // nodes outside the parts from which they read; computed before
};

// The rounds to run one after the other, so that every element that the targets need is computed. Afterwards
// only nodes that are no elements, and nodes that write files, are left. Empty if no node is repeated.
//
// Elements that pass a value to one other element alone are in one part. A node that takes a list of elements
// begins a new round for the elements that depend on it.
std::vector<GraphRound> graph_rounds(const Graph&, const std::vector<int>& targets);

}  // namespace terrazzo
