// JSON as text. Bytes that are not UTF-8, as paths may hold, become U+FFFD: nlohmann's own default would
// throw.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace terrazzo {

// `indent`: −1 for one line.
inline std::string json_text(const nlohmann::json& j, int indent = -1) {
  return j.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace terrazzo
