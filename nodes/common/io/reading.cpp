#include "nodes/common/io/reading.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "graph/diagnostic.h"
#include "graph/utf8.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

constexpr std::size_t kLongestQuote = 200;

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
    const std::size_t length = utf8_length(foreign.substr(at, 4));
    const auto first = static_cast<unsigned char>(c);
    const bool control = first < 0x20 || first == 0x7f ||
                         (first == 0xc2 && length == 2 && static_cast<unsigned char>(foreign[at + 1]) < 0xa0);
    const bool good = length > 0 && !control;
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
