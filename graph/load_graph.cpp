// Loading graph files.
#include <fmt/format.h>

#include <fstream>

#include "graph/linker.h"

namespace terrazzo {
namespace fs = std::filesystem;

std::optional<std::string> read_graph_text(const fs::path& file, Diagnostics& found) {
  const auto fail = [&](std::string code, std::string message, std::string hint) {
    found.push_back({Severity::Error, std::move(code), std::move(message), std::move(hint), {}, {}, {}});
    return std::nullopt;
  };
  std::error_code error;
  std::ifstream in(file, std::ios::binary);
  if (!in || fs::is_directory(file, error))
    return fail("no-file", fmt::format("cannot read the graph file '{}'", file.string()), {});
  std::string text;
  char part[1 << 16];
  while (in && text.size() <= max_graph_bytes) {  // the file may be an endless device
    in.read(part, sizeof part);
    text.append(part, static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) return fail("no-file", fmt::format("cannot read the graph file '{}'", file.string()), {});
  if (text.size() > max_graph_bytes)
    return fail("too-large",
                fmt::format("the graph file '{}' has more than {} MiB", file.string(), max_graph_bytes >> 20),
                "move data to separate files and refer to them in the graph");
  return text;
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
