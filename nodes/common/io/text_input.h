// Text files as programs write them: in UTF-8, UTF-16 or Windows-1252, with any line ends.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "nodes/common/io/reading.h"

namespace terrazzo {

// The whole text of a file as valid UTF-8, without a byte order mark. Line ends stay as they are. Throws
// Error "too-large" and "unreadable-file", which for well-known binary formats says what the file is.
std::string read_text(const std::filesystem::path&, const Reading&);

// The same for bytes that were read already. UTF-16 is recognized by its byte order mark, or else by the zero
// byte in its first character. Text that is not UTF-8 and has no character beyond ASCII that is valid UTF-8
// is read as Windows-1252; otherwise the invalid bytes become U+FFFD. Both are a warning. `name` is used in
// messages.
std::string as_utf8(std::string bytes, const std::string& name, const Reading&);

// Lines end with LF, CR LF, or CR. Takes the next line, without its end, from `at` on, and moves `at` behind
// the end. Returns false at the end of the text.
bool next_line(std::string_view text, std::size_t& at, std::string_view& line);
// Position of the next line end, or the length of the text.
std::size_t line_end(std::string_view text, std::size_t from);
// Position of the first byte of the line after the line end at `at`.
std::size_t after_line_end(std::string_view text, std::size_t at);
// At least the number of lines.
std::size_t count_lines(std::string_view text);

}  // namespace terrazzo
