// UTF-8 checks for text from outside, and how such text is shown. Graph files must be UTF-8; invalid bytes in
// data are replaced.
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

// The three functions below make foreign text safe for terminals and text files. They replace characters that
// steer a terminal or change how the rest of a line is read by escapes such as \u001b: control characters
// (U+0000 to U+001F, U+007F to U+009F), separators of lines, and overrides and isolates of the writing
// direction. In quotes, JSON and YAML read such an escape as the character. Invalid bytes become U+FFFD.

// Keeps line ends (also \r\n) and tabs.
std::string escape_controls(std::string_view text);
// Escapes line ends and tabs, too.
std::string escape_line(std::string_view text);
// For quotes in messages: collapses runs of blanks and line ends, and cuts the text to `longest` bytes.
std::string printable(std::string_view text, std::size_t longest = 200);

}  // namespace terrazzo
