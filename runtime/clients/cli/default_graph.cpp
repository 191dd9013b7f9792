#include "runtime/clients/cli/default_graph.h"

#include "graph/diagnostic.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;

namespace {

fs::path find_graph(const std::string& name) {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (error) return {};
  // CMake links `graphs` in the build folder to the source tree.
  for (const char* graphs : {"../share/terrazzo/graphs", "graphs"})
    if (const fs::path file = fs::canonical(folder / graphs / name, error); !error) return file;
  return {};
}

}  // namespace

fs::path default_graph() { return find_graph("materials/terrazzo.yaml"); }

fs::path installed_graph(const std::string& name) {
  const fs::path file = find_graph(name);
  if (file.empty())
    throw Error("usage", "the graph '" + name + "' is not installed with this program", "reinstall Terrazzo");
  return file;
}

}  // namespace terrazzo::cli
