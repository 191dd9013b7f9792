#include "runtime/clients/studio/live/expand_subgraph.h"

#include <algorithm>
#include <map>
#include <set>

#include "graph/document/paste_nodes.h"
#include "graph/text/element_name.h"
#include "runtime/clients/studio/new_material.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

Error cannot(const std::string& why) { return Error("cannot-edit", why, "edit the text of the file"); }

Workspace around(const fs::path& a, const fs::path& b) {
  fs::path common;
  const fs::path one = fs::absolute(a).parent_path(), other = fs::absolute(b).parent_path();
  const auto end = std::mismatch(one.begin(), one.end(), other.begin(), other.end()).first;
  for (auto part = one.begin(); part != end; ++part) common /= *part;
  return Workspace(common);
}

class Expansion {
 public:
  Expansion(const ReadGraph& graph, const fs::path& file, const RawNode& asset, const Registry& registry)
      : outer_(graph.document), file_(file), asset_(asset), registry_(registry) {
    const fs::path own = (file.parent_path() / asset.graph).lexically_normal();
    Diagnostics found;
    const auto text = read_graph_text(own, found);
    if (!text) throw Error(found.front());
    inner_ = read_graph(relocated(*text, own, file, around(own, file), registry), file);
    if (has_errors(inner_.found)) throw Error(inner_.found.front());
  }

  std::string run(const std::string& text) {
    rename_nodes();
    set_parameters();
    connect_inputs();
    remove_what_nobody_reads();
    std::string out = paste_nodes(text, file_, inner_.text).text;
    const auto apply = [&](const Edit& e) { out = edit_document(out, file_, e); };
    for (const auto& [port, wire] : inner_.document.outputs) {
      apply({.kind = Edit::Kind::Rewire, .name = asset_.name + "." + port, .to = wire.text});
      if (inner_.document.outputs.size() == 1)
        apply({.kind = Edit::Kind::Rewire, .name = asset_.name, .to = wire.text});
    }
    apply({.kind = Edit::Kind::RemoveNode, .node = asset_.name});
    return out;
  }

 private:
  void apply(const Edit& e) { inner_ = edit_document(inner_, file_, e); }

  void rename_nodes() {
    std::set<std::string> taken;
    for (const RawDocument* doc : {&outer_, static_cast<const RawDocument*>(&inner_.document)})
      for (const RawNode& n : doc->nodes) taken.insert(n.name);
    for (const RawNode& n : std::vector(inner_.document.nodes)) {
      if (std::ranges::none_of(outer_.nodes, [&](const RawNode& o) { return o.name == n.name; })) continue;
      std::string name = asset_.name + "_" + n.name;
      for (int k = 2; taken.count(name); ++k) name = asset_.name + "_" + n.name + "_" + std::to_string(k);
      taken.insert(name);
      apply({.kind = Edit::Kind::RenameNode, .node = n.name, .to = name});
    }
  }

  // The value of a parameter of the subgraph.
  const WrittenValue& value_of(const std::string& name) const {
    for (const auto& [given, value] : asset_.params)
      if (given == name) return value.written;
    for (const RawParameter& p : inner_.document.parameters)
      if (p.declaration.name == name && !p.value.written.items.empty()) return p.value.written;
    throw cannot("the subgraph's parameter '" + name + "' has no value");
  }

  // The value with the parameters' values in place of their names.
  WrittenValue substituted(const WrittenValue& value) const {
    if (!value.is_list && value.text().starts_with("${") && value.text().find('}') + 1 == value.text().size())
      return value_of(value.text().substr(2, value.text().size() - 3));
    WrittenValue out{value.is_list, value.items, {}};
    for (std::string& item : out.items)
      for (std::size_t at = 0; (at = item.find("${", at)) != std::string::npos;) {
        const std::size_t end = item.find('}', at);
        if (end == std::string::npos) break;
        const std::string now = value_of(item.substr(at + 2, end - at - 2)).text();
        item.replace(at, end + 1 - at, now);
        at += now.size();
      }
    return out;
  }

  void set_parameters() {
    const auto mentions = [](const WrittenValue& v) {
      return std::ranges::any_of(v.items,
                                 [](const std::string& i) { return i.find("${") != std::string::npos; });
    };
    for (const RawNode& n : std::vector(inner_.document.nodes)) {
      if (!n.each.empty()) throw cannot("the subgraph repeats the node '" + n.name + "'");
      for (const auto& [name, value] : n.params)
        if (mentions(value.written))
          apply({.kind = Edit::Kind::SetParameter,
                 .node = n.name,
                 .name = name,
                 .value = substituted(value.written)});
    }
  }

  // What is connected to the subgraph takes the place of an output in it, or leads to an input.
  void connect_inputs() {
    for (const auto& [input, target] : std::vector(inner_.document.inputs))
      for (const auto& [given, wires] : asset_.inputs) {
        if (given != input || wires.empty()) continue;
        std::vector<std::string> texts;
        for (const auto& w : wires) texts.push_back(w.text);
        if (is_output(target.text)) {
          if (texts.size() > 1) throw cannot("several wires lead to the subgraph's input '" + input + "'");
          apply({.kind = Edit::Kind::Rewire, .name = target.text, .to = texts.front()});
        } else {
          const auto dot = find_port_dot(target.text);
          apply({.kind = Edit::Kind::Connect,
                 .node = target.text.substr(0, dot),
                 .name = target.text.substr(dot + 1),
                 .wires = texts});
        }
      }
  }

  bool is_output(const std::string& reference) const {
    const auto dot = find_port_dot(reference);
    if (dot == std::string::npos) return true;
    for (const RawNode& n : inner_.document.nodes)
      if (const NodeType* type = n.name == reference.substr(0, dot) ? registry_.find(n.type) : nullptr)
        return type->find_output(reference.substr(dot + 1)) != nullptr;
    return true;  // of a subgraph in the subgraph
  }

  void remove_what_nobody_reads() {
    std::set<std::string> needed;
    for (const auto& [port, wire] : inner_.document.outputs)
      if (is_read(port)) need(written_node(wire.text), needed);
    if (needed.empty()) return;
    for (const RawNode& n : std::vector(inner_.document.nodes))
      if (!needed.count(n.name)) apply({.kind = Edit::Kind::RemoveNode, .node = n.name});
  }

  bool is_read(const std::string& port) const {
    const auto is = [&](const RawReference& r) {
      return r.text == asset_.name + "." + port || r.text == asset_.name;
    };
    for (const RawNode& n : outer_.nodes)
      for (const auto& [input, wires] : n.inputs)
        if (std::ranges::any_of(wires, is)) return true;
    return std::ranges::any_of(outer_.outputs, [&](const auto& o) { return is(o.second); });
  }

  void need(const std::string& name, std::set<std::string>& needed) const {
    for (const RawNode& n : inner_.document.nodes)
      if (n.name == name && needed.insert(name).second)
        for (const auto& [input, wires] : n.inputs)
          for (const auto& w : wires) need(written_node(w.text), needed);
  }

  const RawDocument& outer_;
  const fs::path& file_;
  const RawNode& asset_;
  const Registry& registry_;
  ReadGraph inner_;
};

}  // namespace

std::string expand_subgraph(const ReadGraph& graph, const fs::path& file, const std::string& node,
                            const Registry& registry) {
  const auto at = std::ranges::find(graph.document.nodes, node, &RawNode::name);
  if (at == graph.document.nodes.end() || at->graph.empty())
    throw Error("unknown-node", "the graph has no subgraph '" + node + "'");
  if (!at->each.empty() || at->bypass || at->may_fail)
    throw cannot("'" + node + "' is repeated, bypassed or may fail");
  return Expansion(graph, file, *at, registry).run(graph.text);
}

}  // namespace terrazzo::studio
