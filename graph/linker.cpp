// Linking scopes: the root graph and its subgraphs.
#include <fmt/format.h>

#include <algorithm>

#include "graph/linker.h"
#include "graph/numeric_environment.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"

namespace terrazzo {
namespace fs = std::filesystem;

Graph Linker::link(RawDocument doc) {
  const NumericEnvironment numbers;
  graph_.name = doc.name.empty() ? doc.file.stem().string() : doc.name;
  graph_.doc = doc.doc;
  graph_.file = doc.file.string();
  files_.emplace(doc, overrides_.files);
  if (!check_size(doc)) return std::move(graph_);
  expanded_ = files_->root().nodes;
  bytes_ = files_->root().bytes;
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
  if (!too_large_) {
    apply_set();
    check_parameters();
    check_output_paths();
    connect_all(root);
  }
  drop_repeated_messages();
  add_uses_to_messages();
  // In the order of the file.
  std::stable_sort(found_.begin(), found_.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return a.place.file == b.place.file &&
           std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
  });
  return std::move(graph_);
}

void Linker::connect_all(Scope& root) {
  for (auto& [prefix, scope] : scopes_)
    for (const auto& node : scope->doc.nodes)
      if (!too_large_) connect(*scope, node);
  if (too_large_) return;
  check_wiring_of_ports();
  for (const auto& [name, ref] : root.doc.outputs) add_output(name, resolve(root, ref));
  describe_inputs(root);
  report_unused_wires();
  if (sort()) remove_bypassed();
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
  std::map<std::string, const Scope*> first_use;  // by file
  for (const auto& [prefix, scope] : scopes_)
    if (scope->parent) first_use.emplace(scope->doc.file.string(), scope.get());
  for (auto& d : found_) {
    const auto use = first_use.find(d.place.file);
    if (use == first_use.end()) continue;
    const Scope* inside = use->second;
    // If a file is used several times, the node's path identifies the use.
    const std::string path = d.node + "/";
    for (auto slash = path.find('/'); slash != std::string::npos; slash = path.find('/', slash + 1)) {
      const auto meant = scopes_.find(path.substr(0, slash + 1));
      if (meant == scopes_.end() || meant->second->doc.file.string() != d.place.file) continue;
      inside = meant->second.get();
      break;
    }
    d.through = uses(*inside);
  }
}

int Linker::find(const std::string& path) const {
  const auto it = index_.find(path);
  return it == index_.end() ? -1 : it->second;
}

std::string Linker::too_much_text(std::uint64_t bytes) {
  return fmt::format("the graph expands to {} MiB of values and wires; the limit is {}", bytes >> 20,
                     kMaxExpandedBytes >> 20);
}

bool Linker::check_size(const RawDocument& root) {
  const SubgraphFile& all = files_->root();
  const auto larger = [&](const RawNode& a, const RawNode& b) {
    return files_->expansion(root, a).nodes < files_->expansion(root, b).nodes;
  };
  const auto deeper = [&](const RawNode& a, const RawNode& b) {
    return files_->expansion(root, a).nesting < files_->expansion(root, b).nesting;
  };
  if (all.nesting > kMaxNesting) {
    const RawNode& node = *std::max_element(root.nodes.begin(), root.nodes.end(), deeper);
    fail("too-large", fmt::format("subgraphs nest more than {} levels deep in '{}'", kMaxNesting, node.graph),
         node.kind_place, {}, node.name);
  } else if (all.nodes > kMaxExpandedNodes) {
    const RawNode& node = *std::max_element(root.nodes.begin(), root.nodes.end(), larger);
    fail("too-large",
         fmt::format("the graph expands to {} nodes, {} of them in '{}'; the limit is {}", all.nodes,
                     files_->expansion(root, node).nodes, node.name, kMaxExpandedNodes),
         node.kind_place, "use fewer subgraphs, or split the graph into several", node.name);
  } else if (all.bytes > kMaxExpandedBytes) {
    fail("too-large", too_much_text(all.bytes), {root.file.string(), 0, 0},
         "use fewer subgraphs, or shorter lists");
  }
  return all.nesting <= kMaxNesting && all.nodes <= kMaxExpandedNodes && all.bytes <= kMaxExpandedBytes;
}

Scope& Linker::open(RawDocument doc, std::string prefix, Scope* parent, const RawNode* node,
                    std::map<std::string, Given> given) {
  auto owned = std::make_unique<Scope>();
  Scope& scope = *owned;
  scope.prefix = prefix;
  scope.doc = std::move(doc);
  scope.parent = parent;
  scope.node = node;
  if (node) scope.may_fail = node->may_fail ? prefix.substr(0, prefix.size() - 1) : parent->may_fail;
  const auto index = [&scope] {
    scope.nodes.clear();
    for (const auto& raw : scope.doc.nodes) scope.nodes.emplace(raw.name, &raw);
  };
  for (const auto& raw : scope.doc.nodes) scope.names.push_back(raw.name);
  index();
  scopes_[prefix] = std::move(owned);
  rename_former_ports(scope);
  fill_parameters(scope, std::move(given));
  repeat_nodes(scope);
  index();
  override_wires(scope);
  for (const auto& raw : scope.doc.nodes) {
    if (too_large_) break;
    raw.graph.empty() ? add_node(scope, raw) : add_subgraph(scope, raw);
  }
  return scope;
}

void Linker::add_node(Scope& scope, const RawNode& raw) {
  GraphNode node;
  node.path = scope.prefix + raw.name;
  node.place = raw.place;
  node.through = uses(scope);
  node.may_fail = raw.may_fail ? node.path : scope.may_fail;
  if (raw.bypass) bypassed_.insert(node.path);
  node.type = registry_.find(raw.type);
  if (!node.type && (node.type = registry_.find_former(raw.type)))
    note("former-name", fmt::format("{} is now called {}", raw.type, node.type->name), raw.kind_place,
         node.path);
  if (!node.type) {
    unknown_.insert(node.path);
    return fail(
        "unknown-type",
        fmt::format("there is no node type '{}'{}", raw.type, did_you_mean(raw.type, registry_.names())),
        raw.kind_place, {}, node.path);
  }
  for (const auto& [name, value] : raw.params) set_parameter(node, name, substitute(scope, value, &raw));
  index_[node.path] = graph_.nodes.size();
  graph_.nodes.push_back(std::move(node));
}

void Linker::add_subgraph(Scope& scope, const RawNode& raw) {
  const std::string path = scope.prefix + raw.name;
  if (raw.bypass)
    fail("cannot-bypass", fmt::format("'{}' is a subgraph, which cannot be bypassed", raw.name), raw.place,
         "remove bypass, or bypass nodes in its file", path);
  const std::set<std::string>& recursive =
      scope.parent ? files_->open(scope.parent->doc, *scope.node).recursive : files_->root().recursive;
  if (recursive.count(scope.written_name(raw))) {
    unknown_.insert(path);
    return fail("recursion", fmt::format("'{}' contains itself", raw.graph), raw.kind_place, {}, path);
  }
  const SubgraphFile& file = files_->open(scope.doc, raw);
  for (Diagnostic d : file.found) {
    d.node = path;
    if (!file.doc) d.place = raw.kind_place;
    found_.push_back(std::move(d));
  }
  if (!file.doc) {
    unknown_.insert(path);
    return;
  }
  std::map<std::string, Given> given;
  for (const auto& [name, value] : raw.params) {
    Given g = substitute(scope, value, &raw);
    if (!g.written.items.empty() || g.written.is_list) given[name] = std::move(g);
  }
  for (std::size_t i = 0; i < overrides_.set.size(); ++i) {
    const auto& [target, value] = overrides_.set[i];
    if (const auto dot = find_port_dot(target);
        dot != std::string::npos && is_named(path, target.substr(0, dot))) {
      used_[i] = true;
      given[target.substr(dot + 1)] = from_command_line(value, "--set " + target);
    }
  }
  open(*file.doc, path + "/", &scope, &raw, std::move(given));
}

}  // namespace terrazzo
