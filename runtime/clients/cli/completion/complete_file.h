// Shell completion of file names.
#pragma once

#include <string>
#include <vector>

namespace terrazzo::cli {

enum class FileKind { any, graph, folder };

// The files of a kind, and all folders, whose path begins with `typed`, sorted. Folders end in '/'.
std::vector<std::string> complete_file(const std::string& typed, FileKind);

}  // namespace terrazzo::cli
