#include "graph/text/utf8.h"

#include <fmt/format.h>

#include <cstdint>

namespace terrazzo {
namespace {

// The code point of one valid character.
std::uint32_t code_point(std::string_view character) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(character[i]); };
  std::uint32_t out = character.size() == 1 ? byte(0) : byte(0) & (0xffu >> (character.size() + 1));
  for (std::size_t i = 1; i < character.size(); ++i) out = out << 6 | (byte(i) & 0x3fu);
  return out;
}

bool steers(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || (c >= 0x2028 && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

// The first character of `text` as it is shown; `length`: its length.
std::string shown(std::string_view text, std::size_t& length) {
  length = utf8_length(text.substr(0, 4));
  if (length == 0) {
    length = 1;
    return "\xef\xbf\xbd";
  }
  const std::uint32_t c = code_point(text.substr(0, length));
  return steers(c) ? fmt::format("\\u{:04x}", c) : std::string(text.substr(0, length));
}

std::string escaped(std::string_view text, bool keep_lines) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const bool line = text[at] == '\n' || text[at] == '\t' || text.substr(at, 2) == "\r\n";
    if ((text[at] >= ' ' && text[at] < 0x7f) || (line && keep_lines)) {
      out += text[at++];
      continue;
    }
    std::size_t length = 0;
    out += shown(text.substr(at), length);
    at += length;
  }
  return out;
}

}  // namespace

std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xc2 && first < 0xe0   ? 2
                             : (first & 0xf0) == 0xe0        ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  const bool overlong = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
  const bool surrogate = first == 0xed && byte(1) >= 0xa0, beyond = first == 0xf4 && byte(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

std::size_t find_invalid_utf8(std::string_view text, std::size_t from) {
  while (from < text.size()) {
    const std::size_t n = utf8_length(text.substr(from));
    if (n == 0) return from;
    from += n;
  }
  return std::string_view::npos;
}

std::string valid_utf8(std::string text) {
  std::size_t bad = find_invalid_utf8(text);
  if (bad == std::string::npos) return text;
  std::string out;
  std::size_t from = 0;
  for (; bad != std::string::npos; from = bad + 1, bad = find_invalid_utf8(text, from))
    out.append(text, from, bad - from).append("\xef\xbf\xbd");
  return out.append(text, from);
}

std::string escape_controls(std::string_view text) { return escaped(text, true); }

std::string escape_line(std::string_view text) { return escaped(text, false); }

std::string printable(std::string_view text, std::size_t longest) {
  std::string out;
  bool blank = false;
  for (std::size_t at = 0; at < text.size();) {
    if (is_blank(text[at])) {
      blank = !out.empty();
      ++at;
      continue;
    }
    std::size_t length = 0;
    const std::string next = shown(text.substr(at), length);
    if (out.size() + blank + next.size() > longest) return out + "...";
    if (blank) out += ' ';
    blank = false;
    out += next;
    at += length;
  }
  return out;
}

}  // namespace terrazzo
