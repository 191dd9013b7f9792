#include "runtime/clients/studio/live/collapse_nodes.h"

#include <algorithm>
#include <map>
#include <set>

#include "graph/document/patch_yaml.h"
#include "graph/document/yaml_text.h"
#include "graph/text/element_name.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

Error cannot(const std::string& why, const std::string& hint) { return Error("cannot-edit", why, hint); }

bool mentions(const WrittenValue& value, const std::string& parameter) {
  return std::ranges::any_of(
      value.items, [&](const std::string& i) { return i.find("${" + parameter + "}") != std::string::npos; });
}

class Collapse {
 public:
  Collapse(const ReadGraph& graph, const fs::path& file, const std::vector<std::string>& nodes,
           const std::string& name)
      : graph_(graph), file_(file), name_(name), chosen_(nodes.begin(), nodes.end()) {
    for (const std::string& n : nodes)
      if (std::ranges::none_of(graph.document.nodes, [&](const RawNode& o) { return o.name == n; }))
        throw Error("unknown-node", "there is no node '" + n + "'");
    if (nodes.empty()) throw Error("unknown-node", "no nodes are selected");
    find_inputs();
    find_outputs();
    find_parameters();
  }

  std::string outer(const std::string& subgraph_file) const {
    ReadGraph now = graph_;
    const auto apply = [&](const Edit& e) { now = edit_document(now, file_, e); };
    apply({.kind = Edit::Kind::AddNode, .node = name_, .graph = subgraph_file});
    for (const Input& i : inputs_)
      apply({.kind = Edit::Kind::Connect, .node = name_, .name = i.name, .wires = i.wires});
    for (const std::string& p : parameters_)
      apply({.kind = Edit::Kind::SetParameter,
             .node = name_,
             .name = p,
             .value = {false, {"${" + p + "}"}, {}}});
    for (const auto& [wire, output] : outputs_)
      apply({.kind = Edit::Kind::Rewire, .name = wire, .to = name_ + "." + output});
    for (const std::string& n : chosen_) apply({.kind = Edit::Kind::RemoveNode, .node = n});
    return now.text;
  }

  std::string inner() const {
    ReadGraph now = graph_;
    for (const RawNode& n : graph_.document.nodes)
      if (!chosen_.count(n.name))
        now = edit_document(now, file_, {.kind = Edit::Kind::RemoveNode, .node = n.name});
    std::string text = std::move(now.text);
    const auto remove = [&](const YamlPath& path) { text = remove_yaml_entry(text, path).value_or(text); };
    remove({"outputs"});
    remove({"doc"});
    if (parameters_.empty()) remove({"parameters"});
    for (const RawParameter& p : graph_.document.parameters)
      if (!parameters_.count(p.declaration.name)) remove({"parameters", p.declaration.name});
    const auto set = [&](const YamlPath& path, const std::string& value) {
      const auto changed = set_yaml_entry(text, path, yaml_word(value));
      if (!changed) throw cannot("the text has no place for '" + path.front() + "'", "edit it as text");
      text = *changed;
    };
    set({"name"}, name_);
    for (const Input& i : inputs_) set({"inputs", i.name}, i.target);
    for (const auto& [wire, output] : outputs_) set({"outputs", output}, wire);
    // What stands above the graph is about all of it.
    while (text.starts_with('#') || text.starts_with('\n')) text.erase(0, text.find('\n') + 1);
    return text;
  }

 private:
  struct Input {
    std::string name, target;
    std::vector<std::string> wires;
  };

  bool is_chosen(const RawReference& wire) const { return chosen_.count(written_node(wire.text)) > 0; }

  static void require_whole(const RawReference& wire) {
    if (wire.text.find_first_of("[$") != std::string::npos)
      throw cannot("the wire from '" + wire.text + "' is one of elements", "select all nodes at both ends");
  }

  // `port`, or with the node's name before it if that is taken.
  static std::string free_name(std::set<std::string>& taken, const std::string& node,
                               const std::string& port) {
    std::string name = port;
    for (int k = 1; !taken.insert(name).second; ++k)
      name = node + "_" + port + (k == 1 ? "" : "_" + std::to_string(k));
    return name;
  }

  void find_inputs() {
    std::set<std::string> taken;
    for (const RawNode& n : graph_.document.nodes) {
      if (!chosen_.count(n.name)) continue;
      for (const auto& [port, wires] : n.inputs) {
        const auto inside = std::ranges::count_if(wires, [&](const auto& w) { return is_chosen(w); });
        if (inside == std::ssize(wires)) continue;
        if (inside > 0)
          throw cannot("'" + n.name + "." + port + "' has wires from inside and outside of the selection",
                       "select the nodes of all its wires, or of none");
        Input input{free_name(taken, n.name, port), n.name + "." + port, {}};
        for (const auto& w : wires) {
          require_whole(w);
          input.wires.push_back(w.text);
        }
        inputs_.push_back(std::move(input));
      }
    }
    for (const auto& [port, target] : graph_.document.inputs)
      if (is_chosen(target))
        throw cannot("the graph's input '" + port + "' leads to '" + target.text + "'",
                     "leave that node out");
  }

  void find_outputs() {
    std::set<std::string> taken;
    const auto add = [&](const RawReference& wire) {
      if (!is_chosen(wire) || outputs_.count(wire.text)) return;
      require_whole(wire);
      const auto dot = find_port_dot(wire.text);
      const std::string node = written_node(wire.text);
      outputs_[wire.text] =
          free_name(taken, node, dot == std::string::npos ? node : wire.text.substr(dot + 1));
    };
    for (const RawNode& n : graph_.document.nodes)
      if (!chosen_.count(n.name))
        for (const auto& [port, wires] : n.inputs) std::ranges::for_each(wires, add);
    for (const auto& [name, wire] : graph_.document.outputs) add(wire);
  }

  void find_parameters() {
    const auto used_by = [&](const RawNode& n, const std::string& p) {
      const auto in = [&](const auto& v) { return mentions(v.second.written, p); };
      return std::ranges::any_of(n.params, in) || std::ranges::any_of(n.each, in);
    };
    for (const RawParameter& p : graph_.document.parameters)
      for (const RawNode& n : graph_.document.nodes)
        if (chosen_.count(n.name) && used_by(n, p.declaration.name)) parameters_.insert(p.declaration.name);
    for (bool grown = true; grown;) {  // defaults may mention others
      const std::size_t before = parameters_.size();
      for (const RawParameter& p : graph_.document.parameters)
        for (const RawParameter& other : graph_.document.parameters)
          if (parameters_.count(p.declaration.name) && mentions(p.value.written, other.declaration.name))
            parameters_.insert(other.declaration.name);
      grown = parameters_.size() > before;
    }
  }

  const ReadGraph& graph_;
  const fs::path& file_;
  const std::string& name_;
  std::set<std::string> chosen_;
  std::vector<Input> inputs_;
  std::map<std::string, std::string> outputs_;  // names of the subgraph's outputs, by the wire as written
  std::set<std::string> parameters_;
};

}  // namespace

NewSubgraph collapse_nodes(const ReadGraph& graph, const fs::path& file,
                           const std::vector<std::string>& nodes, const std::string& name,
                           const std::string& subgraph_file) {
  const Collapse all(graph, file, nodes, name);
  return {all.outer(subgraph_file), all.inner()};
}

}  // namespace terrazzo::studio
