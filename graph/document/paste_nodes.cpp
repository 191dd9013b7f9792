#include "graph/document/paste_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "graph/document/edit_document.h"
#include "graph/document/patch_yaml.h"
#include "graph/document/write_document.h"
#include "graph/document/yaml_tree.h"
#include "graph/text/element_name.h"

namespace terrazzo {
namespace {

constexpr std::size_t kMostPastedNodes = 500;  // each edit of their text reads all of it

const YamlNode* entry_named(const YamlNode& map, const std::string& key) {
  for (const auto& [name, value] : map.entries)
    if (name.text == key) return &value;
  return nullptr;
}

// Calls use(line) for each line, without its end.
template <class Use>
void each_line_of(const std::string& text, Use&& use) {
  for (std::size_t at = 0; at < text.size();) {
    const auto stop = std::min(text.find('\n', at), text.size());
    use(text.substr(at, stop - at));
    at = stop + 1;
  }
}

// What was copied, as a graph file.
std::string as_graph_file(std::string nodes) {
  std::erase(nodes, '\r');
  const auto tree = read_yaml_tree(nodes);
  const YamlNode* inner = tree ? entry_named(*tree, "nodes") : nullptr;
  // Nodes may have any name, also `nodes`; but then that has a type.
  if (inner && inner->kind == YamlNode::Kind::Map && !entry_named(*inner, "type") &&
      !entry_named(*inner, "graph"))
    return entry_named(*tree, "terrazzo") ? nodes : fmt::format("terrazzo: {}\n{}", kGraphFormat, nodes);
  std::string out = fmt::format("terrazzo: {}\nnodes:\n", kGraphFormat);
  each_line_of(nodes, [&](const std::string& line) { out += (line.empty() ? "" : "  " + line) + "\n"; });
  return out;
}

// The lines of all nodes, without indentation.
std::string node_lines(const std::string& file) {
  const auto tree = read_yaml_tree(file);
  const YamlNode* nodes = tree ? entry_named(*tree, "nodes") : nullptr;
  const auto refuse = [] {
    return Error("cannot-edit", "the nodes that were pasted are all on one line",
                 "write each node on a line of its own");
  };
  if (!nodes || nodes->flow || nodes->entries.empty()) throw refuse();
  const std::size_t key = nodes->entries.front().first.begin, before = file.rfind('\n', key);
  const std::size_t first = before == std::string::npos ? 0 : before + 1, indent = key - first;
  if (file.find_first_not_of(' ', first) != key) throw refuse();
  const auto& [name, value] = nodes->entries.back();
  const std::size_t last = file.find('\n', std::max(name.end, value.end));
  std::string out;
  each_line_of(file.substr(first, last == std::string::npos ? last : last - first),
               [&](const std::string& line) {
                 out += line.substr(std::min({indent, line.find_first_not_of(' '), line.size()})) + "\n";
               });
  return out;
}

}  // namespace

Pasted paste_nodes(const std::string& text, const std::filesystem::path& file, const std::string& nodes) {
  Diagnostics found;
  RawDocument doc = read_document(text, file, found);
  if (has_errors(found))
    throw Error("cannot-edit", "the file has errors: " + found.front().message, "correct the text first");
  std::string added = as_graph_file(nodes);
  const RawDocument copied = read_document(added, file, found);
  if (has_errors(found) || copied.nodes.empty())
    throw Error("no-nodes",
                "the pasted text contains no nodes" + (found.empty() ? "" : ": " + found.front().message),
                "copy nodes in the Studio, or lines of a graph file");
  if (copied.nodes.size() > kMostPastedNodes)
    throw Error("too-large",
                fmt::format("{} nodes were pasted; the limit is {}", copied.nodes.size(), kMostPastedNodes),
                "copy them in the text of the file");

  Pasted out;
  std::set<std::string> taken, own;
  for (const RawNode& n : doc.nodes) taken.insert(n.name);
  for (const RawNode& n : copied.nodes) own.insert(n.name);
  for (const RawNode& n : copied.nodes) {
    std::string name = n.name;
    const auto digits = name.find_last_not_of("0123456789");
    const bool numbered =
        digits != std::string::npos && digits > 0 && digits + 1 < name.size() && name[digits] == '_';
    const std::string stem = numbered ? name.substr(0, digits) : name;
    for (int k = 2; taken.count(name) || (name != n.name && own.count(name)); ++k)
      name = fmt::format("{}_{}", stem, k);
    if (name != n.name)
      added = edit_document(added, file, {.kind = Edit::Kind::RenameNode, .node = n.name, .to = name});
    taken.insert(name);
    out.names.emplace_back(n.name, name);
  }
  for (const RawNode& n : read_document(added, file, found).nodes)
    for (const auto& [input, wires] : n.inputs) {
      std::vector<std::string> kept;
      for (const auto& w : wires)
        if (w.text.find("${") != std::string::npos || taken.count(written_node(w.text)))
          kept.push_back(w.text);
      if (kept.size() < wires.size())
        added = edit_document(added, file,
                              {.kind = Edit::Kind::Connect, .node = n.name, .name = input, .wires = kept});
    }

  const auto patched = add_yaml_lines(text, {"nodes"}, node_lines(added));
  const RawDocument again = patched ? read_document(*patched, file, found) : RawDocument();
  for (RawNode& n : read_document(added, file, found).nodes) doc.nodes.push_back(std::move(n));
  if (!patched || has_errors(found) || !same_document(again, doc))
    throw Error("cannot-edit", "the nodes cannot be added to this file without changing something else",
                "edit the text of the file");
  out.text = *patched;
  return out;
}

}  // namespace terrazzo
