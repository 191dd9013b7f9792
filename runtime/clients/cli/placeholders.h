// The placeholders that stand for values in help, in the manual and in shell completion. An option's
// placeholder, which is its type name in CLI11, decides how the shell completes its value.
#pragma once

namespace terrazzo::cli::placeholder {

inline constexpr const char *graph = "GRAPH", *node_type = "TYPE";
inline constexpr const char *file = "FILE", *folder = "FOLDER", *image = "IMAGE";
inline constexpr const char *number = "N", *bytes = "BYTES";
inline constexpr const char* node_setting = "NODE.PARAM=VALUE";
inline constexpr const char* graph_setting = "NAME=VALUE";
inline constexpr const char* varied_setting = "[NODE.]PARAM=VALUES";  // of a node or of the graph
inline constexpr const char *target = "NODE[.PORT]", *output = "NODE.PORT";

}  // namespace terrazzo::cli::placeholder
