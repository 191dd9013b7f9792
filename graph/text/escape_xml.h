// Text for XML files, as element content or in an attribute in double quotes.
#pragma once

#include <string>
#include <string_view>

#include "graph/text/utf8.h"

namespace terrazzo {

inline std::string escape_xml(std::string_view text) {
  std::string out;
  for (const char c : escape_controls(text)) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

}  // namespace terrazzo
