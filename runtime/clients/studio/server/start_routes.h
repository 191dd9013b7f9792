// The routes with which the page opens and creates graphs.
#pragma once

#include "graph/registry.h"

namespace terrazzo::studio {

class LiveGraph;
class LocalServer;
struct StudioStart;

// GET /api/start: {welcome, folder, materials: [{name, title, doc, picture}], graphs: [{file, changed}]}, the
// graphs below the workspace. GET /api/picture/NAME: the picture of a material. POST /api/open {material or
// graph, discard}. POST /api/photograph?name&folder&pixel_size&
// content=particles|phases&discard, with the bytes of a picture: creates a graph of it in a folder below the
// workspace, and opens it. POST /api/recommend?name, with these bytes: {content, why}. POST /api/save_as
// {file}: below the workspace. Other answers name the `file` that is open then. All arguments must outlive
// the server.
void add_start_routes(LocalServer&, LiveGraph&, const Registry&, const StudioStart&);

}  // namespace terrazzo::studio
