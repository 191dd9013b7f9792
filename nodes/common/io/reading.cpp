#include "nodes/common/io/reading.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "graph/diagnostic.h"
#include "runtime/context.h"

namespace terrazzo {

Reading reading_of(Context& c) {
  return {c.memory(), [&c](const std::string& message) { c.warn(message); }};
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
