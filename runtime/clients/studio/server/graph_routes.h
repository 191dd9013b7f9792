// What a page asks about the graph besides its state: prices of edits, earlier states, the inside of
// subgraphs, files that it may read, and where the page's user has put nodes and notes.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "graph/document/edit_document.h"
#include "graph/registry.h"
#include "runtime/clients/studio/live/arrangement.h"

namespace terrazzo::studio {

class LiveGraph;
class LocalServer;

// The edits of a request. Throws Error "bad-request".
std::vector<Edit> edits_of(const nlohmann::json&);

// Where a request puts nodes that it adds, if it says so.
Places places_of(const nlohmann::json& body);

// The path of the subgraph that a request is about, or "" for the document.
std::string scope_of(const nlohmann::json& body);

void add_graph_routes(LocalServer&, LiveGraph&, const Registry&);

}  // namespace terrazzo::studio
