#include "nodes/common/io/reading.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "graph/diagnostic.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

constexpr std::size_t kLongestQuote = 200;

// Length of the UTF-8 character at the start of `text`, or 0 if it is invalid.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xc2 && first < 0xe0   ? 2
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  // Reject overlong forms, surrogates, values beyond the last code point, and C1 control characters.
  if ((first == 0xe0 && byte(1) < 0xa0) || (first == 0xed && byte(1) > 0x9f) ||
      (first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) > 0x8f) ||
      (first == 0xc2 && byte(1) < 0xa0))
    return 0;
  return length;
}

}  // namespace

Reading reading_of(Context& c) {
  return {c.memory(), [&c](const std::string& message) { c.warn(message); }};
}

std::string printable(std::string_view foreign) {
  std::string out;
  bool blank = false;
  for (std::size_t at = 0; at < foreign.size();) {
    const char c = foreign[at];
    if (c == ' ' || c == '\n' || c == '\t' || c == '\r') {
      blank = !out.empty();
      ++at;
      continue;
    }
    const std::size_t length = character_length(foreign.substr(at, 4));
    const bool good = length > 0 && static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    const std::string_view next = good ? foreign.substr(at, length) : "?";
    if (out.size() + blank + next.size() > kLongestQuote) return out + "...";
    if (blank) out += ' ';
    blank = false;
    out += next;
    at += good ? length : 1;
  }
  return out;
}

std::string read_whole(const std::filesystem::path& path, const Reading& reading) {
  const auto unreadable = [&](const std::string& why) {
    return Error("unreadable-file", "cannot read '" + path.string() + "': " + why,
                 "check that the file exists and is readable");
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw unreadable("it is not a regular file");
  const auto size = std::filesystem::file_size(path, error);
  if (error) throw unreadable(error.message());
  require_memory(static_cast<double>(size), reading.memory, "'" + path.string() + "'");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw unreadable(std::strerror(errno));
  std::string content(size, '\0');
  in.read(content.data(), static_cast<std::streamsize>(size));
  if (in.bad()) throw unreadable(std::strerror(errno));
  content.resize(static_cast<std::size_t>(in.gcount()));
  return content;
}

}  // namespace terrazzo
