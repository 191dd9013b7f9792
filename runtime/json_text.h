// JSON as text. Replaces invalid UTF-8, which paths may contain, with U+FFFD, where nlohmann::json would
// throw by default, and escapes all characters that steer a terminal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "graph/text/utf8.h"

namespace terrazzo {

// `indent`: spaces per level, or −1 for one line.
inline std::string json_text(const nlohmann::json& j, int indent = -1) {
  return escape_controls(j.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace terrazzo
