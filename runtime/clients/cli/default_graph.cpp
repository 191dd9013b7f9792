#include "runtime/clients/cli/default_graph.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;

fs::path default_graph() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (error) return {};
  // CMake links `graphs` in the build folder to the source tree.
  for (const char* graphs : {"../share/terrazzo/graphs", "graphs"})
    if (const fs::path file = fs::canonical(folder / graphs / "materials/terrazzo.yaml", error); !error)
      return file;
  return {};
}

}  // namespace terrazzo::cli
