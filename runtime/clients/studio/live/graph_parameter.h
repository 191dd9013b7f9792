// Parameters of the graph that are made of a node's.
#pragma once

#include <filesystem>
#include <string>

#include "graph/document/edit_document.h"
#include "graph/registry.h"

namespace terrazzo::studio {

struct NewGraphParameter {
  std::string name;
  std::string text;  // of the graph
};

// The graph with one more parameter, which has the declaration and the present value of a node's parameter
// and which that reads now. Its name is the parameter's if it is free, else with the node's name before it.
// Throws Error "unknown-node", "unknown-parameter", "cannot-edit", and what edit_document() throws.
NewGraphParameter with_graph_parameter(const ReadGraph&, const std::filesystem::path& file, const Registry&,
                                       const std::string& node, const std::string& parameter);

}  // namespace terrazzo::studio
