// Text from outside: graph files must be UTF-8; in data what is not is replaced.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace terrazzo {

// Where the first bytes stand that are not UTF-8 (overlong forms and surrogates included), or npos.
std::size_t find_invalid_utf8(std::string_view text, std::size_t from = 0);
// The text with every such byte replaced by U+FFFD.
std::string valid_utf8(std::string text);

}  // namespace terrazzo
