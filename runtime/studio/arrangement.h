// Where a person put nodes, notes and frames: a file beside the graph, so that differences of the graph stay
// clean.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace terrazzo::studio {

// "stones.yaml" has the arrangement "stones.studio.json".
std::filesystem::path arrangement_file(const std::filesystem::path& graph);

// {places: {node: [x, y]}, notes: [{x, y, width, height, text, frame}]} as the page wrote it; an
// empty object if there is none, or if it is no arrangement.
nlohmann::json read_arrangement(const std::filesystem::path& graph);
// Never replaces another file of that name. Removes the file if the arrangement is empty. Throws Error
// "bad-request" if it is none, "too-large" or "write-failed".
void write_arrangement(const std::filesystem::path& graph, const nlohmann::json&);

}  // namespace terrazzo::studio
