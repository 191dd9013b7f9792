// Node types and graphs as text and JSON: reference, schema for editors, drawings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "graph/graph.h"
#include "graph/registry.h"

namespace terrazzo {

nlohmann::json describe_json(const NodeType&);
std::string describe_text(const NodeType&);
std::string describe_markdown(const NodeType&);
// "1 mm, above 0", "auto", "required"
std::string range_text(const Parameter&);

// A graph as if it were a node type: its parameters, its inputs and outputs with the types they end in.
NodeType describe_graph(const Graph&);

// JSON Schema (draft 2020-12) of graph files, for completion and checking in editors.
nlohmann::json graph_schema(const Registry&);

std::string draw_dot(const Graph&);
std::string draw_mermaid(const Graph&);
std::string draw_svg(const Graph&);

}  // namespace terrazzo
