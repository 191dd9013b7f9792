#include "graph/document/subgraph_files.h"

#include <algorithm>

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

fs::path file_of(const RawDocument& doc, const RawNode& node) {
  return (doc.file.parent_path() / node.graph).lexically_normal();
}

// Identifies a file. Symbolic links can give one folder infinitely many names, so links in the folder are
// resolved. The file name stays as written, because paths in the file are relative to the folder that
// contains this name.
fs::path identity(const fs::path& file) {
  std::error_code error;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const fs::path real = fs::weakly_canonical(folder, error);
  return (error ? folder : real) / file.filename();
}

// What a copy of a node takes: its values and wires, and their places.
std::uint64_t bytes_of(const RawNode& node) {
  constexpr std::uint64_t kPerItem = 64;
  std::uint64_t bytes = kPerItem + node.doc.size();
  const auto add = [&](const std::string& text) { bytes += kPerItem + text.size(); };
  for (const auto* values : {&node.each, &node.params})
    for (const auto& [name, value] : *values)
      for (const auto& item : value.written.items) add(item);
  for (const auto& [port, references] : node.inputs)
    for (const auto& reference : references) add(reference.text);
  return bytes;
}

// Clamped to avoid overflow. Far beyond the limit, the exact number does not matter.
void add(std::uint64_t& sum, std::uint64_t more) { sum = std::min(sum + more, std::uint64_t{1} << 60); }

}  // namespace

SubgraphFiles::SubgraphFiles(const RawDocument& root, const std::map<fs::path, std::string>& texts)
    : texts_(texts) {
  around_.insert(identity(root.file));
  count(root, root_, 0);
}

std::optional<std::string> SubgraphFiles::text_of(const fs::path& file, Diagnostics& found) const {
  const auto it = texts_.find(file);
  return it == texts_.end() ? read_graph_text(file, found) : it->second;
}

void SubgraphFiles::count(const RawDocument& doc, SubgraphFile& into, int level) {
  for (const auto& node : doc.nodes) {
    Expansion e{.bytes = bytes_of(node)};
    if (!node.graph.empty()) {
      const fs::path id = identity(file_of(doc, node));
      if (around_.count(id)) {
        into.recursive.insert(node.name);
      } else {
        const auto [at, fresh] = files_.try_emplace(id);
        SubgraphFile& file = at->second;
        if (fresh && level < kMaxNesting) {
          if (const auto text = text_of(file_of(doc, node), file.found)) {
            file.doc = read_document(*text, file_of(doc, node), file.found);
            around_.insert(id);
            count(*file.doc, file, level + 1);
            around_.erase(id);
          }
        }
        e = {file.nodes + 1, file.bytes + e.bytes, file.nesting + 1};
      }
    }
    add(into.nodes, e.nodes);
    add(into.bytes, e.bytes);
    into.nesting = std::max(into.nesting, e.nesting);
  }
}

const SubgraphFile& SubgraphFiles::open(const RawDocument& doc, const RawNode& node) const {
  return files_.at(identity(file_of(doc, node)));
}

Expansion SubgraphFiles::expansion(const RawDocument& doc, const RawNode& node) const {
  Expansion out{.bytes = bytes_of(node)};
  if (node.graph.empty()) return out;
  const auto it = files_.find(identity(file_of(doc, node)));
  if (it == files_.end()) return out;
  return {it->second.nodes + 1, it->second.bytes + out.bytes, it->second.nesting + 1};
}

}  // namespace terrazzo
