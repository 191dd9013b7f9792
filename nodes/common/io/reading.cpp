#include "nodes/common/io/reading.h"

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "runtime/context.h"

namespace terrazzo {

Reading reading_of(Context& c) {
  return {c.memory(), [&c](const std::string& message) { c.warn(message); }};
}

std::string read_whole(const std::filesystem::path& path, const Reading& reading) {
  FileText file = read_input_file(path, reading.memory);
  if (file.too_large) {
    std::error_code ignored;
    require_memory(std::filesystem::file_size(path, ignored), reading.memory, "'" + path.string() + "'");
  }
  if (!file)
    throw Error("unreadable-file", "cannot read '" + path.string() + "': " + file.trouble,
                "check that the file exists and is readable");
  return std::move(file.text);
}

}  // namespace terrazzo
