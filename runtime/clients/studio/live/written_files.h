// The files that a graph writes, as the page lists and downloads them.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "graph/graph.h"
#include "runtime/clients/studio/live/node_states.h"

namespace terrazzo::studio {

// One entry per file: {node, path, bytes}. Of a node that has run in this session, the files that it wrote;
// of others, the file of their parameter. `path` is relative to the folder; `bytes` is missing if there is no
// such file.
nlohmann::json written_files(const Graph&, const NodeStates&, const std::filesystem::path& folder);

// The file with this path, which written_files() lists. Throws Error "no-file", also for a link out of the
// folder.
std::filesystem::path written_file(const Graph&, const NodeStates&, const std::filesystem::path& folder,
                                   const std::string& path);

}  // namespace terrazzo::studio
