// Scopes: the graph itself and the subgraphs in it.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "graph/linker.h"
#include "graph/nearest.h"

namespace terrazzo {
namespace fs = std::filesystem;

Graph Linker::link(RawDocument doc) {
  graph_.name = doc.name.empty() ? doc.file.stem().string() : doc.name;
  graph_.doc = doc.doc;
  graph_.file = doc.file.string();
  std::map<std::string, Given> given;
  for (const auto& [name, text] : overrides_.parameters)
    given[name] = from_command_line(text, "--param " + name);
  Scope& root = open(std::move(doc), "", nullptr, nullptr, std::move(given));
  for (const auto& p : root.doc.parameters) {
    graph_.parameters.push_back({p.declaration, p.place});
    if (const auto it = root.parameters.find(p.declaration.name); it != root.parameters.end()) {
      std::string why;
      graph_.parameters.back().declaration.value = read_parameter(p.declaration, it->second.written, why);
    }
  }
  apply_set();
  for (auto& [prefix, scope] : scopes_)
    for (const auto& node : scope->doc.nodes) connect(*scope, node);
  check_wiring_of_ports();
  for (const auto& [name, ref] : root.doc.outputs)
    if (const auto w = resolve(root, ref)) graph_.outputs.push_back({name, *w});
  describe_inputs(root);
  report_unused_wires();
  sort();
  add_uses_to_messages();
  // In the order that a reader of the file meets them.
  std::stable_sort(found_.begin(), found_.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return a.place.file == b.place.file &&
           std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
  });
  return std::move(graph_);
}

void Linker::fail(std::string code, std::string message, Place at, std::string hint, std::string node,
                  std::string parameter) {
  found_.push_back({Severity::Error, std::move(code), std::move(message), std::move(hint), std::move(at),
                    std::move(node), std::move(parameter)});
}

void Linker::note(std::string code, std::string message, Place at, std::string node) {
  found_.push_back(
      {Severity::Note, std::move(code), std::move(message), {}, std::move(at), std::move(node), {}});
}

std::vector<Place> Linker::uses(const Scope& scope) {
  std::vector<Place> out;
  for (const Scope* s = &scope; s->parent; s = s->parent) out.push_back(s->node->place);
  return out;
}

void Linker::add_uses_to_messages() {
  for (auto& d : found_) {
    const Scope* inside = nullptr;
    for (const auto& [prefix, scope] : scopes_)
      if (scope->parent && scope->doc.file.string() == d.place.file) {
        // The node's path tells which of several uses of one file is meant.
        const bool meant = (d.node + "/").rfind(prefix, 0) == 0;
        if (!inside || meant) inside = scope.get();
        if (meant) break;
      }
    if (inside) d.through = uses(*inside);
  }
}

int Linker::find(const std::string& path) const {
  const auto it = index_.find(path);
  return it == index_.end() ? -1 : it->second;
}

Scope& Linker::open(RawDocument doc, std::string prefix, Scope* parent, const RawNode* node,
                    std::map<std::string, Given> given) {
  auto owned = std::make_unique<Scope>();
  Scope& scope = *owned;
  scope.prefix = prefix, scope.doc = std::move(doc), scope.parent = parent, scope.node = node;
  scopes_[prefix] = std::move(owned);
  fill_parameters(scope, std::move(given));
  override_wires(scope);
  for (const auto& raw : scope.doc.nodes) raw.graph.empty() ? add_node(scope, raw) : add_subgraph(scope, raw);
  return scope;
}

void Linker::add_node(Scope& scope, const RawNode& raw) {
  GraphNode node;
  node.path = scope.prefix + raw.name;
  node.place = raw.place;
  node.through = uses(scope);
  node.type = registry_.find(raw.type);
  if (!node.type && (node.type = registry_.find_former(raw.type)))
    note("former-name", fmt::format("{} is called {} now", raw.type, node.type->name), raw.kind_place,
         node.path);
  if (!node.type) {
    unknown_.insert(node.path);
    return fail(
        "unknown-type",
        fmt::format("there is no node type '{}'{}", raw.type, did_you_mean(raw.type, registry_.names())),
        raw.kind_place, {}, node.path);
  }
  for (const auto& [name, value] : raw.params) set_parameter(node, name, substitute(scope, value));
  index_[node.path] = static_cast<int>(graph_.nodes.size());
  graph_.nodes.push_back(std::move(node));
}

void Linker::add_subgraph(Scope& scope, const RawNode& raw) {
  const fs::path file = (scope.doc.file.parent_path() / raw.graph).lexically_normal();
  const std::string path = scope.prefix + raw.name;
  for (const Scope* s = &scope; s; s = s->parent)
    if (s->doc.file.lexically_normal() == file) {
      unknown_.insert(path);
      return fail("recursion", fmt::format("'{}' contains itself", raw.graph), raw.kind_place, {}, path);
    }
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    unknown_.insert(path);
    return fail("no-file", fmt::format("cannot read the graph '{}'", file.string()), raw.kind_place, {},
                path);
  }
  std::stringstream text;
  text << in.rdbuf();
  std::map<std::string, Given> given;
  for (const auto& [name, value] : raw.params) {
    Given g = substitute(scope, value);
    if (!g.written.items.empty() || g.written.is_list) given[name] = std::move(g);
  }
  for (std::size_t i = 0; i < overrides_.set.size(); ++i) {
    const auto& [target, value] = overrides_.set[i];
    if (const auto dot = target.rfind('.'); target.substr(0, dot) == path && dot != std::string::npos) {
      used_[i] = true;
      given[target.substr(dot + 1)] = from_command_line(value, "--set " + target);
    }
  }
  Diagnostics inside;
  RawDocument doc = read_document(text.str(), file, inside);
  for (auto& d : inside) d.node = path;
  found_.insert(found_.end(), inside.begin(), inside.end());
  open(std::move(doc), path + "/", &scope, &raw, std::move(given));
}

}  // namespace terrazzo
