#include "runtime/clients/cli/graph_names.h"

#include "graph/document/subgraph_files.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

std::vector<Parameter> declared_parameters(const RawDocument& doc) {
  std::vector<Parameter> out;
  for (const auto& p : doc.parameters) out.push_back(p.declaration);
  return out;
}

void add_names(const RawDocument& doc, const SubgraphFile& file, const SubgraphFiles& files,
               const std::string& prefix, std::vector<NamedNode>& out) {
  for (const auto& node : doc.nodes) {
    const std::string path = prefix + node.name;
    if (node.graph.empty()) {
      out.push_back({path, node.type, {}});
    } else if (!file.recursive.count(node.name)) {
      const SubgraphFile& inner = files.open(doc, node);
      if (!inner.doc) continue;
      out.push_back({path, "", declared_parameters(*inner.doc)});
      add_names(*inner.doc, inner, files, path + "/", out);
    }
  }
}

}  // namespace

GraphNames read_graph_names(const fs::path& file) {
  Diagnostics ignored;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};  // reading a pipe would block
  const auto text = read_graph_text(file, ignored);
  if (!text) return {};
  const RawDocument doc = read_document(*text, file.lexically_normal(), ignored);
  const SubgraphFiles files(doc);
  if (files.root().nodes > kMaxExpandedNodes || files.root().nesting > kMaxNesting) return {};
  GraphNames names;
  names.parameters = declared_parameters(doc);
  for (const auto& [name, wire] : doc.outputs) names.outputs.push_back(name);
  add_names(doc, files.root(), files, "", names.nodes);
  return names;
}

}  // namespace terrazzo::cli
