// Loading graph files.
#include <fmt/format.h>

#include "graph/input_file.h"
#include "graph/linker.h"

namespace terrazzo {
namespace fs = std::filesystem;

std::optional<std::string> read_graph_text(const fs::path& file, Diagnostics& found) {
  const auto fail = [&](std::string code, std::string message, std::string hint) {
    found.push_back({Severity::Error, std::move(code), std::move(message), std::move(hint), {}, {}, {}});
    return std::nullopt;
  };
  FileText read = read_input_file(file, kMaxGraphBytes);
  if (read.too_large)
    return fail("too-large",
                fmt::format("the graph file '{}' has more than {} MiB", file.string(), kMaxGraphBytes >> 20),
                "move data to separate files and refer to them in the graph");
  if (!read)
    return fail("no-file", fmt::format("cannot read the graph file '{}': {}", file.string(), read.trouble),
                {});
  return std::move(read.text);
}

Graph load_graph_text(const std::string& text, const fs::path& file, const Registry& registry,
                      const Overrides& overrides, Diagnostics& found) {
  RawDocument doc = read_document(text, file.lexically_normal(), found);
  return Linker(registry, overrides, found).link(std::move(doc));
}

Graph link_document(RawDocument doc, const Registry& registry, const Overrides& overrides,
                    Diagnostics& found) {
  return Linker(registry, overrides, found).link(std::move(doc));
}

Graph load_graph(const fs::path& file, const Registry& registry, const Overrides& overrides,
                 Diagnostics& found) {
  const auto text = read_graph_text(file, found);
  return text ? load_graph_text(*text, file, registry, overrides, found) : Graph{};
}

}  // namespace terrazzo
