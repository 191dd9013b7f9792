// A subgraph's nodes in place of its node.
#pragma once

#include <filesystem>
#include <string>

#include "graph/document/edit_document.h"
#include "graph/registry.h"

namespace terrazzo::studio {

// The text of the graph with copies of the nodes of a subgraph, as far as their results are read, in place of
// its node. They have the values that the subgraph's parameters have here, and compute the same. Nodes whose
// names are taken get the subgraph's name before theirs. Throws Error "unknown-node" if this is no subgraph,
// "cannot-edit" if it is repeated, bypassed or may fail, or has a parameter without a value, and what
// edit_document() and paste_nodes() throw.
std::string expand_subgraph(const ReadGraph&, const std::filesystem::path& file, const std::string& node,
                            const Registry&);

}  // namespace terrazzo::studio
