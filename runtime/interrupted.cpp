#include "runtime/interrupted.h"

#include <algorithm>

#include "graph/exception_text.h"
#include "runtime/files.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

fs::path unused_name(const fs::path& folder, std::string node, const std::string& extension) {
  std::replace(node.begin(), node.end(), '/', '.');
  const std::string stem = node + ".interrupted";
  fs::path file = folder / (stem + extension);
  std::error_code error;
  for (int k = 2; fs::symlink_status(file, error).type() != fs::file_type::not_found && !error; ++k)
    file = folder / (stem + "_" + std::to_string(k) + extension);
  return file;
}

Diagnostic message_of(Severity severity, const Error& e, const GraphNode& node) {
  Diagnostic d = e.diagnostic();
  d.severity = severity;
  d.node = node.path;
  d.place = node.place;
  d.through = node.through;
  return d;
}

}  // namespace

SavedWork save(const InterruptedWork& work, const GraphNode& node, const fs::path& folder,
               const ProtectedFiles& keep) {
  const fs::path file = unused_name(folder, node.path, work.extension);
  const auto lost = [&](std::string why, const std::string& hint) {
    // Writers know only the temporary name.
    if (const auto at = why.find("': "); at != std::string::npos) why = why.substr(at + 3);
    const Error e("write-failed", "interrupted; cannot save its work in '" + file.string() + "': " + why,
                  hint);
    return SavedWork{{}, message_of(Severity::Warning, e, node)};
  };
  try {
    write_atomically(file, keep, work.write);
    const Error e("interrupted", "interrupted; saved " + work.what + " in '" + file.string() + "'",
                  work.hint);
    return {file, message_of(Severity::Note, e, node)};
  } catch (const Error& e) {
    return lost(e.diagnostic().message, e.diagnostic().hint);
  } catch (const std::exception& e) {
    return lost(exception_text(e), "");
  }
}

}  // namespace terrazzo
