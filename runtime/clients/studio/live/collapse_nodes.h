// Some nodes of a graph as a subgraph.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "graph/document/edit_document.h"

namespace terrazzo::studio {

struct NewSubgraph {
  std::string graph;     // the text of the graph, with a node in place of the others
  std::string subgraph;  // the text of the subgraph
};

// A node `name` in place of `nodes`, and the graph that it uses, which `subgraph_file` shall contain, in the
// same folder. Wires that lead to them become its inputs, and what others read becomes its outputs; it has
// the parameters of the graph that they use. It computes the same. Throws Error "unknown-node", and
// "cannot-edit" where a port has wires from inside and outside, or a wire crosses to or from single elements
// of a repeated node.
NewSubgraph collapse_nodes(const ReadGraph&, const std::filesystem::path& file,
                           const std::vector<std::string>& nodes, const std::string& name,
                           const std::string& subgraph_file);

}  // namespace terrazzo::studio
