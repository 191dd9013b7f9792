// Files that a command must not overwrite.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "graph/document/file_set.h"
#include "graph/graph.h"

namespace terrazzo {

class ProtectedFiles {
 public:
  ProtectedFiles() = default;
  // The graph's own file, the files of its subgraphs, and the files that its nodes read, needed or not.
  explicit ProtectedFiles(const Graph&);

  // `why` follows the path in a message: "which the graph reads".
  void add(const std::filesystem::path&, const std::string& why = "which the graph reads");
  // The protected file that writing to `path` would replace, or null. See FileSet: links, second names and
  // other spellings of a path count as the file itself.
  const std::filesystem::path* replaced_by(const std::filesystem::path& path) const {
    return files_.find(path);
  }
  // Throws Error "overwrites-input" if writing to `path` would replace a protected file. The message calls
  // the path `shown`, by default as it is.
  void require_other(const std::filesystem::path& path, const std::string& shown = {}) const;

 private:
  FileSet files_;
  std::map<std::filesystem::path, std::string> why_;
};

}  // namespace terrazzo
