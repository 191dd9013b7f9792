// The document as the page shows it: nodes with their declarations, values, wires and messages.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "graph/document/raw_document.h"
#include "graph/graph.h"
#include "runtime/clients/studio/live/document.h"

namespace terrazzo::studio {

// {name, nodes, outputs, parameters}. A node is {name, type or graph, doc, line, params, inputs, bypass}; a
// repeated node also has `each`, and a subgraph's node its `declaration` and `inner`: the path and port
// inside of it by output, without the names of elements. Without `drawn`, nodes and outputs are empty.
nlohmann::json json_of(const RawDocument&, const Registry&, bool drawn = true);

// Adds `inner` to the bypassed nodes of such a document: by output, the path and port that is read instead.
// `prefix`: "" or "SUBGRAPH/", where the document is in the graph.
void add_bypassed(nlohmann::json& document, const Graph&, const std::string& prefix);

// Adds what a document is as a file: {file, text, saved, read_only, can_undo, can_redo, arrangement}.
void add_file(nlohmann::json& document, const Document&);

}  // namespace terrazzo::studio
