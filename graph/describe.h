// Node types and graphs as text and JSON: reference pages, the JSON Schema, drawings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "graph/graph.h"
#include "graph/registry.h"

namespace terrazzo {

nlohmann::json describe_json(const NodeType&);
std::string describe_text(const NodeType&);
std::string describe_markdown(const NodeType&);
// The allowed values: "above 0", "1 to 10; or auto", "a, b, c". "" if there is no limit.
std::string range_text(const Parameter&);

// Describes a graph as a node type: its parameters, and its inputs and outputs with the types of the ports
// that they connect to.
NodeType describe_graph(const Graph&);

// JSON Schema (draft 2020-12) of graph files, for completion and validation in editors.
nlohmann::json graph_schema(const Registry&);

std::string draw_dot(const Graph&);
std::string draw_mermaid(const Graph&);
std::string draw_svg(const Graph&);

}  // namespace terrazzo
