// The names in a graph file, for shell completion.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "graph/parameter.h"

namespace terrazzo::cli {

struct NamedNode {
  std::string path;                   // "asset/pack"
  std::string type;                   // "" for a subgraph
  std::vector<Parameter> parameters;  // of a subgraph
};

struct GraphNames {
  std::vector<NamedNode> nodes;  // with those in subgraphs
  std::vector<Parameter> parameters;
  std::vector<std::string> outputs;
};

// Reads a graph without node types, so that it takes milliseconds. Ignores errors in the file. Returns no
// names if the file cannot be read or expands to too many nodes.
GraphNames read_graph_names(const std::filesystem::path&);

}  // namespace terrazzo::cli
