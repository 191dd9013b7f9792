// Linking wires: follows references through subgraphs to the node that produces the value.
#include <fmt/format.h>

#include <algorithm>

#include "graph/linker.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"

namespace terrazzo {
namespace fs = std::filesystem;

const NodeType* Linker::type_of(const RawNode& node) const {
  const NodeType* type = registry_.find(node.type);
  return type ? type : registry_.find_former(node.type);
}

void Linker::rename_former_port(const Scope& scope, RawReference& ref, bool also_inputs) {
  const auto dot = find_port_dot(ref.text);
  if (dot == std::string::npos) return;
  const auto node = scope.nodes.find(written_node(ref.text));
  const NodeType* type = node == scope.nodes.end() ? nullptr : type_of(*node->second);
  const std::string name = ref.text.substr(dot + 1);
  if (!type || type->find_output(name) || (also_inputs && type->find_input(name))) return;
  const Port* port = type->find_former_output(name);
  if (!port && also_inputs) port = type->find_former_input(name);
  if (!port) return;
  note("former-name", fmt::format("'{}' of {} is now called '{}'", name, type->name, port->name), ref.place,
       scope.prefix + node->first);
  ref.text = ref.text.substr(0, dot + 1) + port->name;
}

void Linker::rename_former_ports(Scope& scope) {
  for (RawNode& node : scope.doc.nodes) {
    const NodeType* type = type_of(node);
    for (auto& [name, refs] : node.inputs) {
      if (const Port* port = type && !type->find_input(name) ? type->find_former_input(name) : nullptr) {
        note("former-name", fmt::format("'{}' of {} is now called '{}'", name, type->name, port->name),
             refs.empty() ? node.place : refs.front().place, scope.prefix + node.name);
        name = port->name;
      }
      for (RawReference& ref : refs) rename_former_port(scope, ref, false);
    }
  }
  for (auto& [name, ref] : scope.doc.inputs) rename_former_port(scope, ref, true);
  for (auto& [name, ref] : scope.doc.outputs) rename_former_port(scope, ref, false);
}

void Linker::report_unknown_node(const Scope& scope, const std::string& name, const Place& at) {
  const auto of = scope.lists.find(written_node(name));
  if (of == scope.lists.end())
    fail("unknown-node", fmt::format("there is no node '{}'{}", name, did_you_mean(name, scope.names)), at);
  else
    fail("unknown-node",
         fmt::format("'{}' has no element '{}'{}", of->first, name, did_you_mean(name, of->second)), at,
         fmt::format("its {} elements are {} to {}", of->second.size(), of->second.front(),
                     of->second.back()));
}

void Linker::report_unknown_output(const std::string& of, const std::string& port,
                                   const std::vector<std::string>& names, const Place& at) {
  fail("unknown-port", fmt::format("{} has no output '{}'{}", of, port, did_you_mean(port, names)), at,
       names.empty() ? "it has no outputs" : fmt::format("it has {}", fmt::join(names, ", ")));
}

std::vector<Wire> Linker::resolve(Scope& scope, const RawReference& ref, int depth) {
  const auto dot = find_port_dot(ref.text);
  std::string name = ref.text.substr(0, dot);
  const std::string port = dot == std::string::npos ? "" : ref.text.substr(dot + 1);
  const auto named = scope.nodes.find(name);
  const auto list = scope.lists.find(name);
  const std::string path = scope.prefix + name;
  if (unknown_.count(path) || unknown_.count(scope.prefix + written_node(name))) return {};
  if (named == scope.nodes.end() && list == scope.lists.end()) {
    report_unknown_node(scope, name, ref.place);
    return {};
  }
  if (depth > 4 * kMaxNesting) {
    fail("cycle",
         fmt::format("the wires form a cycle: '{}' leads through subgraphs back to itself", ref.text),
         ref.place);
    return {};
  }
  // The enclosing graph may have replaced this output by connecting one of the subgraph's inputs.
  if (scope.parent)
    for (const auto& [input, target] : scope.doc.inputs)
      if (target.text == ref.text)
        for (const auto& [given, wires] : scope.node->inputs)
          if (given == input && !wires.empty()) {
            std::vector<Wire> out;
            for (const auto& wire : wires)
              for (Wire& w : resolve(*scope.parent, wire, depth + 1)) out.push_back(std::move(w));
            return out;
          }
  if (list != scope.lists.end()) {
    if (!take_elements(list->second.size(), ref)) return {};
    std::vector<Wire> out;
    for (const auto& element : list->second)
      for (Wire& w : resolve(scope, {element + ref.text.substr(name.size()), ref.place}, depth + 1))
        out.push_back(std::move(w));
    return out;
  }
  const RawNode* raw = named->second;
  if (!raw->graph.empty()) {
    const auto it = scopes_.find(path + "/");
    if (it == scopes_.end()) return {};
    std::vector<std::string> names;
    for (const auto& [output, target] : it->second->doc.outputs) {
      if (output == port || (port.empty() && it->second->doc.outputs.size() == 1))
        return resolve(*it->second, target, depth + 1);
      names.push_back(output);
    }
    report_unknown_output(fmt::format("graph '{}'", raw->graph), port, names, ref.place);
    return {};
  }
  const int node = find(path);
  if (node < 0) return {};
  const NodeType& type = *graph_.nodes[node].type;
  if (port.empty() && type.outputs.size() == 1) return {{node, type.outputs[0].name, ref.place}};
  if (type.find_output(port)) return {{node, port, ref.place}};
  std::vector<std::string> names;
  for (const auto& p : type.outputs) names.push_back(p.name);
  report_unknown_output(fmt::format("{} '{}'", type.name, name), port, names, ref.place);
  return {};
}

void Linker::override_wires(Scope& scope) {
  for (std::size_t i = 0; i < overrides_.wires.size(); ++i) {
    const auto& [input, sources] = overrides_.wires[i];
    const auto dot = find_port_dot(input);
    if (dot == std::string::npos || input.rfind(scope.prefix, 0) != 0) continue;
    const std::string name = input.substr(scope.prefix.size(), dot - scope.prefix.size());
    std::vector<RawNode*> nodes;
    for (RawNode& n : scope.doc.nodes)
      if (n.name == name || scope.written_name(n) == name) nodes.push_back(&n);
    if (nodes.empty()) continue;
    used_wires_[i] = true;
    const Place place{"wire to " + input, 0, 0};
    std::vector<RawReference> refs;
    for (const auto& source : sources) {
      if (source.rfind(scope.prefix, 0) != 0) {
        fail("unknown-node", fmt::format("'{}' is not inside the subgraph '{}'", source, scope.prefix),
             place);
        continue;
      }
      refs.push_back({source.substr(scope.prefix.size()), place});
    }
    const std::string port = input.substr(dot + 1);
    for (RawNode* node : nodes) {
      std::erase_if(node->inputs, [&](const auto& written) { return written.first == port; });
      if (!refs.empty()) node->inputs.emplace_back(port, refs);
    }
  }
}

void Linker::report_unused_wires() {
  for (std::size_t i = 0; i < used_wires_.size(); ++i)
    if (!used_wires_[i]) {
      const std::string& input = overrides_.wires[i].first;
      const std::string path = input.substr(0, find_port_dot(input));
      fail("unknown-node", fmt::format("there is no node '{}'{}", path, did_you_mean(path, graph_.paths())),
           {"wire to " + input, 0, 0}, input.find('.') == std::string::npos ? "write NODE.INPUT" : "");
    }
}

void Linker::connect(Scope& scope, const RawNode& raw) {
  const std::string path = scope.prefix + raw.name;
  if (!raw.graph.empty()) return check_subgraph_inputs(scope, raw);
  const int index = find(path);
  if (index < 0) {
    for (const auto& [port, refs] : raw.inputs)
      for (const auto& ref : refs) resolve(scope, ref);  // reports errors in the references
    return;
  }
  for (const auto& [port, refs] : raw.inputs) {
    GraphNode& node = graph_.nodes[index];
    const Port* p = node.type->find_input(port);
    if (!p) {
      std::vector<std::string> names;
      for (const auto& q : node.type->inputs) names.push_back(q.name);
      fail("unknown-port",
           fmt::format("{} has no input '{}'{}", node.type->name, port, did_you_mean(port, names)),
           refs.front().place, {}, path);
      continue;
    }
    if (refs.size() > 1 && !p->many) {
      fail("too-many-wires", fmt::format("input '{}' accepts one wire, not {}", port, refs.size()),
           refs[1].place, {}, path);
      continue;
    }
    for (const auto& ref : refs) attach(scope, index, *p, ref);
  }
  // Inputs of this subgraph that lead to an input of this node.
  if (scope.parent)
    for (const auto& [input, target] : scope.doc.inputs)
      for (const auto& [given, wires] : scope.node->inputs) {
        const GraphNode& node = graph_.nodes[index];
        const std::string start = scope.written_name(raw) + ".";
        if (given != input || target.text.rfind(start, 0) != 0) continue;
        const Port* p = node.type->find_input(target.text.substr(start.size()));
        if (p && !node.type->find_output(p->name))
          for (const auto& ref : wires) attach(*scope.parent, index, *p, ref);
      }
}

void Linker::attach(Scope& scope, int index, const Port& port, const RawReference& ref) {
  broken_inputs_.insert({index, port.name});  // prevents a misleading second message, "missing input"
  if (!take_wires(0, ref)) return;
  std::vector<Wire> wires = resolve(scope, ref);
  GraphNode& node = graph_.nodes[index];
  if (wires.size() > 1 && !port.many)
    return fail(
        "too-many-wires",
        fmt::format("input '{}' accepts one wire, but {} is a list of {}", port.name, ref.text, wires.size()),
        ref.place, "name one element in brackets, or repeat this node too", node.path);
  if (!take_wires(wires.size(), ref)) return;
  for (Wire& w : wires) {
    const std::string& type = graph_.nodes[w.node].type->find_output(w.port)->types[0];
    if (!port.accepts(type))
      return fail(
          "wrong-type",
          fmt::format("input '{}' accepts {}, but {} is {}", port.name, port.type_text(), ref.text, type),
          ref.place, {}, node.path);
    w.place = ref.place;
    node.inputs[port.name].push_back(std::move(w));
  }
}

bool Linker::take_elements(std::size_t count, const RawReference& ref) {
  if (too_large_) return false;
  elements_ += count;
  if (elements_ <= 2 * kMaxExpandedWires) return true;
  too_large_ = true;
  fail("too-large", fmt::format("the wires lead to more than {} elements", 2 * kMaxExpandedWires), ref.place,
       "connect lists to fewer elements");
  return false;
}

bool Linker::take_wires(std::size_t wires, const RawReference& ref) {
  if (too_large_) return false;
  wires_ += wires;
  if (wires_ <= kMaxExpandedWires) return true;
  too_large_ = true;
  fail("too-large", fmt::format("the graph expands to more than {} wires", kMaxExpandedWires), ref.place,
       "connect lists to fewer elements");
  return false;
}

void Linker::add_output(const std::string& name, const std::vector<Wire>& wires) {
  for (std::size_t k = 0; k < wires.size(); ++k)
    graph_.outputs.push_back({wires.size() == 1 ? name : element_name(name, {{"", k}}), wires[k]});
}

void Linker::check_subgraph_inputs(Scope& scope, const RawNode& raw) {
  const auto it = scopes_.find(scope.prefix + raw.name + "/");
  if (it == scopes_.end()) return;
  std::vector<std::string> names;
  for (const auto& [input, target] : it->second->doc.inputs) names.push_back(input);
  for (const auto& [port, refs] : raw.inputs) {
    if (std::find(names.begin(), names.end(), port) == names.end())
      fail("unknown-port",
           fmt::format("graph '{}' has no input '{}'{}", raw.graph, port, did_you_mean(port, names)),
           refs.front().place);
    for (const auto& ref : refs) resolve(scope, ref);
  }
}

void Linker::describe_inputs(Scope& root) {
  for (const auto& [name, ref] : root.doc.inputs) {
    const auto dot = find_port_dot(ref.text);
    const auto list = root.lists.find(ref.text.substr(0, dot));
    const int index = find(list == root.lists.end() ? ref.text.substr(0, dot) : list->second.front());
    const std::string port = dot == std::string::npos ? "" : ref.text.substr(dot + 1);
    const NodeType* type = index < 0 ? nullptr : graph_.nodes[index].type;
    const Port* input = type ? type->find_input(port) : nullptr;
    const Port* output = type ? type->find_output(port) : nullptr;
    if (!input || output) {  // the input replaces an output, perhaps one of an inner subgraph
      const auto wires = resolve(root, ref);
      if (wires.empty()) continue;
      output = graph_.nodes[wires[0].node].type->find_output(wires[0].port);
    }
    Port p = output ? *output : *input;
    p.name = name;
    p.optional = output || input->optional;  // without a wire, the replaced output is used
    graph_.inputs.push_back(std::move(p));
  }
}

void Linker::check_wiring_of_ports() {
  for (std::size_t i = 0; i < graph_.nodes.size(); ++i) {
    const GraphNode& node = graph_.nodes[i];
    if (bypassed_.count(node.path)) continue;  // nothing reads its inputs and parameters
    for (const auto& port : node.type->inputs)
      if (!port.optional && !node.inputs.count(port.name) &&
          !broken_inputs_.count({static_cast<int>(i), port.name}))
        fail("missing-input",
             fmt::format("{} needs the input '{}' ({})", node.type->name, port.name, port.type_text()),
             node.place, {}, node.path);
    for (const auto& p : node.type->parameters)
      if (!p.value && !node.parameters.count(p.name) && !attempted_.count({node.path, p.name}))
        fail("missing-parameter",
             fmt::format("{} needs the parameter '{}' ({})", node.type->name, p.name, p.doc), node.place, {},
             node.path);
  }
}

void Linker::report_cycle(const std::vector<int>& way, int node) {
  std::string text;
  const auto begin = std::find(way.begin(), way.end(), node);
  for (auto it = begin; it != way.end() && it - begin < 50; ++it) text += graph_.nodes[*it].path + " → ";
  if (way.end() - begin > 50) text += "… → ";
  const auto& last = graph_.nodes[node];
  fail("cycle", "the wires form a cycle: " + text + last.path, last.place);
}

bool Linker::sort() {
  const std::size_t n = graph_.nodes.size();
  enum { unseen, open, placed };
  std::vector<int> state(n, unseen), order,
      way;  // path from a node upstream; an explicit stack, because recursion could overflow
  std::vector<std::vector<int>> sources(n);  // for nodes in `way`: sources still to be visited
  const auto visit = [&](int i) {
    const std::size_t at = i;
    state[at] = open;
    way.push_back(i);
    for (const auto& [port, wires] : graph_.nodes[at].inputs)
      for (const auto& w : wires) sources[at].push_back(w.node);
    std::reverse(sources[at].begin(), sources[at].end());
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (state[i] == unseen) visit(static_cast<int>(i));
    while (!way.empty()) {
      const std::size_t at = way.back();
      if (sources[at].empty()) {
        state[at] = placed;
        order.push_back(way.back());
        way.pop_back();
        continue;
      }
      const int next = sources[at].back();
      sources[at].pop_back();
      if (state[next] == open) {
        report_cycle(way, next);
        return false;
      }
      if (state[next] == unseen) visit(next);
    }
  }
  std::vector<int> place(n);
  std::vector<GraphNode> sorted;
  for (std::size_t k = 0; k < n; ++k) place[order[k]] = k;
  for (const int i : order) {
    sorted.push_back(std::move(graph_.nodes[i]));
    for (auto& [port, wires] : sorted.back().inputs)
      for (auto& w : wires) w.node = place[w.node];
  }
  graph_.nodes = std::move(sorted);
  for (auto& o : graph_.outputs) o.wire.node = place[o.wire.node];
  return true;
}

}  // namespace terrazzo
