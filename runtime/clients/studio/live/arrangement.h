// Where a person put nodes, notes and frames: a file beside the graph, so that differences of the graph stay
// clean.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace terrazzo::studio {

// Upper left corners of nodes, x to the right and y down, in pixels of the canvas at 100 %.
using Places = std::map<std::string, std::array<double, 2>>;

// "stones.yaml" has the arrangement "stones.yaml.studio.json".
std::filesystem::path arrangement_file(const std::filesystem::path& graph);

// The text of an arrangement, as its file contains it: {places: {node: [x, y]}, notes: [{x, y, width, height,
// text, frame}]}; "" if it is empty. Throws Error "bad-request" if it is none, "too-large" above 1 MiB.
std::string arrangement_text(const nlohmann::json&);
// The JSON object of such a text.
nlohmann::json arrangement_json(const std::string& text);
// The same arrangement with more places. Throws as arrangement_text() does.
std::string arrangement_placed(const std::string& text, const Places&);
// The same arrangement after a node got another name.
std::string arrangement_renamed(const std::string& text, const std::string& from, const std::string& to);

// The text of the arrangement beside a graph; "" if there is no file, nothing if the file is no arrangement.
// Without one, reads "stones.studio.json", which earlier versions wrote.
std::optional<std::string> read_arrangement(const std::filesystem::path& graph);
// Never replaces another file of that name. Removes the file if the text is empty, and the file of an earlier
// version unless another graph reads it too. The file has the permissions of the graph. Throws Error
// "file-exists" or "write-failed".
void write_arrangement(const std::filesystem::path& graph, const std::string& text);

}  // namespace terrazzo::studio
