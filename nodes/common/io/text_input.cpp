#include "nodes/common/io/text_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "graph/diagnostic.h"
#include "graph/text/utf8.h"

namespace terrazzo {
namespace {

using namespace std::string_view_literals;

Error no_text(const std::string& name, std::string_view what, std::string_view hint) {
  return Error("unreadable-file", fmt::format("'{}' is not a text file: it is {}", name, what),
               std::string(hint));
}

struct Signature {
  std::string_view begin, what, hint;
};
constexpr Signature kSignatures[] = {
    {"PK\x03\x04"sv, "a ZIP archive, as Excel (.xlsx) and OpenOffice (.ods) write",
     "save the sheet as CSV, or unpack the archive"},
    {"\xd0\xcf\x11\xe0"sv, "a document of Microsoft Office, such as .xls", "save the sheet as CSV"},
    {"\x89HDF\r\n"sv, "an HDF5 file", "export the data as text from the program that wrote it"},
    {"\x1f\x8b"sv, "compressed by gzip", "unpack it with gunzip"},
    {"%PDF-"sv, "a PDF document", "export the data as CSV"},
};

void put_utf8(std::string& out, std::uint32_t code) {
  const auto put = [&](std::uint32_t byte) { out += static_cast<char>(byte); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xc0 | code >> 6);
    put(0x80 | (code & 0x3f));
  } else if (code < 0x10000) {
    put(0xe0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  } else {
    put(0xf0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3f));
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  }
}

constexpr std::uint32_t kUnknownCharacter = 0xfffd;

// Single surrogates become U+FFFD.
std::string from_utf16(std::string_view bytes, bool big_endian) {
  const std::size_t units = bytes.size() / 2;
  const auto unit = [&](std::size_t i) -> std::uint32_t {
    const unsigned char a = bytes[2 * i], b = bytes[2 * i + 1];
    return big_endian ? a << 8 | b : b << 8 | a;
  };
  std::string out;
  out.reserve(units + units / 8);
  for (std::size_t i = 0; i < units; ++i) {
    const std::uint32_t c = unit(i);
    const bool high = c >= 0xd800 && c < 0xdc00, low = c >= 0xdc00 && c < 0xe000;
    const std::uint32_t next = high && i + 1 < units ? unit(i + 1) : 0;
    if (next >= 0xdc00 && next < 0xe000) {
      put_utf8(out, 0x10000 + ((c - 0xd800) << 10) + (next - 0xdc00));
      ++i;
    } else {
      put_utf8(out, high || low ? kUnknownCharacter : c);
    }
  }
  return out;
}

std::string from_windows_1252(std::string_view bytes) {
  // 0x80 to 0x9f; the rest is Latin-1.
  static constexpr std::uint16_t kHigh[] = {0x20ac, 0xfffd, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021,
                                            0x02c6, 0x2030, 0x0160, 0x2039, 0x0152, 0xfffd, 0x017d, 0xfffd,
                                            0xfffd, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014,
                                            0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0xfffd, 0x017e, 0x0178};
  std::string out;
  for (const char c : bytes) {
    const unsigned char byte = c;
    put_utf8(out, byte >= 0x80 && byte < 0xa0 ? kHigh[byte - 0x80] : byte);
  }
  return out;
}

bool has_valid_character_beyond_ascii(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text.substr(at, 4));
    if (length > 1) return true;
    ++at;
  }
  return false;
}

enum class Encoding { Bytes, Utf16Little, Utf16Big };

// By the byte order mark, or else by the pattern of zeros in the first character, which is ASCII in every
// text that is read here (as RFC 4627 does for JSON).
Encoding encoding_of(std::string_view bytes, std::size_t& mark, const std::string& name) {
  mark = 0;
  if (bytes.starts_with("\xff\xfe\0\0"sv) || bytes.starts_with("\0\0\xfe\xff"sv) ||
      bytes.starts_with("\0\0\0"sv) ||
      (bytes.size() >= 4 && bytes[0] != 0 && bytes.substr(1, 3) == "\0\0\0"sv))
    throw no_text(name, "encoded as UTF-32", "save it as UTF-8");
  mark = 2;
  if (bytes.starts_with("\xff\xfe"sv)) return Encoding::Utf16Little;
  if (bytes.starts_with("\xfe\xff"sv)) return Encoding::Utf16Big;
  mark = bytes.starts_with("\xef\xbb\xbf"sv) ? 3 : 0;
  if (bytes.size() >= 2 && bytes[0] != 0 && bytes[1] == 0) return Encoding::Utf16Little;
  if (bytes.size() >= 2 && bytes[0] == 0 && bytes[1] != 0) return Encoding::Utf16Big;
  return Encoding::Bytes;
}

}  // namespace

std::string as_utf8(std::string bytes, const std::string& name, const Reading& reading) {
  for (const Signature& s : kSignatures)
    if (std::string_view(bytes).starts_with(s.begin)) throw no_text(name, s.what, s.hint);
  std::size_t mark = 0;
  const Encoding encoding = encoding_of(bytes, mark, name);
  if (encoding != Encoding::Bytes) {
    if (bytes.size() % 2 != 0)
      throw Error("unreadable-file", fmt::format("'{}' is UTF-16 and ends within a character", name),
                  "the file may be truncated; save it again, as UTF-8");
    require_memory(2.5 * bytes.size(), reading.memory, "'" + name + "'");
    return from_utf16(std::string_view(bytes).substr(mark), encoding == Encoding::Utf16Big);
  }
  bytes.erase(0, mark);
  if (const auto zero = bytes.find('\0'); zero != std::string::npos)
    throw no_text(name, fmt::format("binary, with a zero byte at position {}", zero + mark),
                  "export the data as text");
  if (find_invalid_utf8(bytes) == std::string::npos) return bytes;
  require_memory(4.0 * bytes.size(), reading.memory, "'" + name + "'");
  const std::string file = std::filesystem::path(name).filename().string();
  if (has_valid_character_beyond_ascii(bytes)) {
    reading.warn("'" + file + "' is not UTF-8: invalid bytes are read as U+FFFD");
    return valid_utf8(std::move(bytes));
  }
  reading.warn("'" + file + "' is not UTF-8: it is read as Windows-1252 (Latin-1)");
  return from_windows_1252(bytes);
}

std::string read_text(const std::filesystem::path& path, const Reading& reading) {
  return as_utf8(read_whole(path, reading), path.string(), reading);
}

std::size_t line_end(std::string_view text, std::size_t from) {
  return std::min(text.find_first_of("\r\n", from), text.size());
}

std::size_t after_line_end(std::string_view text, std::size_t at) {
  if (at >= text.size()) return text.size();
  return at + (text[at] == '\r' && at + 1 < text.size() && text[at + 1] == '\n' ? 2 : 1);
}

bool next_line(std::string_view text, std::size_t& at, std::string_view& line) {
  if (at >= text.size()) return false;
  const auto end = line_end(text, at);
  line = text.substr(at, end - at);
  at = after_line_end(text, end);
  return true;
}

std::size_t count_lines(std::string_view text) {
  std::size_t lines = 1;
  for (std::size_t i = 0; i < text.size(); ++i)
    lines += text[i] == '\n' || (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n'));
  return lines;
}

}  // namespace terrazzo
