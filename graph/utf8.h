// UTF-8 checks for text from outside. Graph files must be UTF-8; invalid bytes in data are replaced.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace terrazzo {

// Length in bytes of the character at the start of `text`, or 0 if it is invalid (RFC 3629).
std::size_t utf8_length(std::string_view text);
// Position of the first byte that is not valid UTF-8, or npos. Overlong forms and surrogates are invalid.
std::size_t find_invalid_utf8(std::string_view text, std::size_t from = 0);
// The text with every invalid byte replaced by U+FFFD.
std::string valid_utf8(std::string text);

}  // namespace terrazzo
