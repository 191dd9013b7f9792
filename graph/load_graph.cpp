// Reads graph files.
#include <fstream>
#include <sstream>

#include "graph/linker.h"

namespace terrazzo {
namespace fs = std::filesystem;

Graph load_graph_text(const std::string& text, const fs::path& file, const Registry& registry,
                      const Overrides& overrides, Diagnostics& found) {
  RawDocument doc = read_document(text, file.lexically_normal(), found);
  return Linker(registry, overrides, found).link(std::move(doc));
}

Graph load_graph(const fs::path& file, const Registry& registry, const Overrides& overrides,
                 Diagnostics& found) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  if (!in || fs::is_directory(file) || !(text << in.rdbuf())) {
    found.push_back(
        {Severity::Error, "no-file", "cannot read the graph file '" + file.string() + "'", {}, {}, {}, {}});
    return {};
  }
  return load_graph_text(text.str(), file, registry, overrides, found);
}

}  // namespace terrazzo
