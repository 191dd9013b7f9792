// From files to a Graph: opens subgraphs, fills in parameters, resolves wires, checks everything it meets.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <memory>
#include <set>
#include <sstream>

#include "graph/graph.h"
#include "graph/nearest.h"
#include "graph/raw_document.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

// A written value with the folder that relative paths in it mean, and where it came from.
struct Given {
  WrittenValue written;
  fs::path folder;
  Place place;
};

// One opened file: the graph itself, or a subgraph under the path of its node.
struct Scope {
  std::string prefix;  // "" or "asset/"
  RawDocument doc;
  Scope* parent = nullptr;
  const RawNode* node = nullptr;  // in the parent
  std::map<std::string, Given> parameters;
};

class Linker {
 public:
  Linker(const Registry& registry, const Overrides& overrides, Diagnostics& found)
      : registry_(registry), overrides_(overrides), found_(found), used_(overrides.set.size(), false) {}

  Graph link(RawDocument doc) {
    graph_.name = doc.name.empty() ? doc.file.stem().string() : doc.name;
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
    sort();
    // In the order that a reader of the file meets them.
    std::stable_sort(found_.begin(), found_.end(), [](const Diagnostic& a, const Diagnostic& b) {
      return a.place.file == b.place.file &&
             std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
    });
    return std::move(graph_);
  }

 private:
  void fail(std::string code, std::string message, Place at, std::string hint = {}, std::string node = {},
            std::string parameter = {}) {
    found_.push_back({Severity::Error, std::move(code), std::move(message), std::move(hint), std::move(at),
                      std::move(node), std::move(parameter)});
  }

  Given from_command_line(const std::string& text, const std::string& what) {
    Given g{{false, {text}}, fs::current_path(), {"command line (" + what + ")", 0, 0}};
    try {
      g.written = read_written(text);
    } catch (const Error& e) {
      fail("bad-value", e.diagnostic().message, g.place);
    }
    return g;
  }

  int find(const std::string& path) const {
    const auto it = index_.find(path);
    return it == index_.end() ? -1 : it->second;
  }

  // --- parameters

  // Replaces ${name}. A value that is nothing but one reference keeps the type and origin of what it names.
  Given substitute(const Scope& scope, const RawValue& raw) {
    Given out{raw.written, fs::path(raw.place.file).parent_path(), raw.place};
    for (auto& item : out.written.items) {
      std::string text;
      std::size_t at = 0;
      while (true) {
        const auto open = item.find("${", at);
        const auto close = open == std::string::npos ? open : item.find('}', open);
        if (close == std::string::npos) break;
        const std::string name = item.substr(open + 2, close - open - 2);
        const auto it = scope.parameters.find(name);
        if (it == scope.parameters.end()) {
          std::vector<std::string> names;
          for (const auto& p : scope.doc.parameters) names.push_back(p.declaration.name);
          if (std::find(names.begin(), names.end(), name) == names.end())
            fail("unknown-parameter",
                 fmt::format("the graph has no parameter '{}'{}", name, did_you_mean(name, names)),
                 raw.place);
          return out.written.items.clear(), out;
        }
        if (!raw.written.is_list && open == 0 && close + 1 == item.size()) {
          Given whole = it->second;
          whole.place =
              it->second.place.line > 0 || !it->second.place.file.empty() ? it->second.place : raw.place;
          return whole;
        }
        text += item.substr(at, open - at) + it->second.written.text();
        at = close + 1;
      }
      item = text + item.substr(at);
    }
    return out;
  }

  void fill_parameters(Scope& scope, std::map<std::string, Given> given) {
    std::vector<std::string> names;
    for (const auto& p : scope.doc.parameters) {
      const std::string& name = p.declaration.name;
      names.push_back(name);
      Given value;
      if (const auto it = given.find(name); it != given.end()) {
        value = std::move(it->second);
        given.erase(it);
      } else if (!p.value.written.items.empty() || p.value.written.is_list) {
        value = {p.value.written, scope.doc.file.parent_path(), p.value.place};
      } else {
        fail("missing-parameter", fmt::format("parameter '{}' has no default and must be set", name),
             scope.node ? scope.node->place : p.place);
        continue;
      }
      std::string why;
      if (!read_parameter(p.declaration, value.written, why)) {
        fail("bad-value", why, value.place, {},
             scope.prefix.empty() ? "" : scope.prefix.substr(0, scope.prefix.size() - 1), name);
        continue;
      }
      scope.parameters[name] = std::move(value);
    }
    for (const auto& [name, value] : given)
      fail("unknown-parameter",
           fmt::format("{} has no parameter '{}'{}", scope.node ? "'" + scope.node->graph + "'" : "the graph",
                       name, did_you_mean(name, names)),
           value.place);
  }

  void set_parameter(GraphNode& node, const std::string& name, const Given& given) {
    attempted_.insert({node.path, name});
    const Parameter* p = node.type->find_parameter(name);
    if (!p) {
      std::vector<std::string> names;
      for (const auto& q : node.type->parameters) names.push_back(q.name);
      return fail("unknown-parameter",
                  fmt::format("{} has no parameter '{}'{}", node.type->name, name, did_you_mean(name, names)),
                  given.place, {}, node.path);
    }
    if (given.written.items.empty() && !given.written.is_list)
      return;  // already reported where it was substituted
    std::string why;
    auto value = read_parameter(*p, given.written, why);
    if (!value) return fail("bad-value", why, given.place, {}, node.path, name);
    if (p->kind == ParameterKind::InputPath) {
      fs::path path = std::get<std::string>(*value);
      if (path.is_relative()) path = given.folder / path;
      value = fs::absolute(path).lexically_normal().string();
    }
    node.parameters[name] = {std::move(*value), given.place, given.written.text()};
  }

  // --- scopes

  Scope& open(RawDocument doc, std::string prefix, Scope* parent, const RawNode* node,
              std::map<std::string, Given> given) {
    auto owned = std::make_unique<Scope>();
    Scope& scope = *owned;
    scope.prefix = prefix, scope.doc = std::move(doc), scope.parent = parent, scope.node = node;
    scopes_[prefix] = std::move(owned);
    fill_parameters(scope, std::move(given));
    for (const auto& raw : scope.doc.nodes)
      raw.graph.empty() ? add_node(scope, raw) : add_subgraph(scope, raw);
    return scope;
  }

  void add_node(Scope& scope, const RawNode& raw) {
    GraphNode node;
    node.path = scope.prefix + raw.name;
    node.place = raw.place;
    node.type = registry_.find(raw.type);
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

  void add_subgraph(Scope& scope, const RawNode& raw) {
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

  void apply_set() {
    for (std::size_t i = 0; i < overrides_.set.size(); ++i) {
      if (used_[i]) continue;
      const auto& [target, value] = overrides_.set[i];
      const Given given = from_command_line(value, "--set " + target);
      const auto dot = target.rfind('.');
      const int node = dot == std::string::npos ? -1 : find(target.substr(0, dot));
      if (node >= 0)
        set_parameter(graph_.nodes[static_cast<std::size_t>(node)], target.substr(dot + 1), given);
      else if (!unknown_.count(target.substr(0, dot)))
        fail("unknown-node",
             fmt::format("there is no node '{}'{}", target.substr(0, dot),
                         did_you_mean(target.substr(0, dot), graph_.paths())),
             given.place, dot == std::string::npos ? "write NODE.PARAM=VALUE" : "");
    }
  }

  // --- wires

  // Follows a reference through subgraphs to the node that makes the value. Mistakes are reported once, where
  // written.
  std::optional<Wire> resolve(Scope& scope, const RawReference& ref, int depth = 0) {
    const auto dot = ref.text.rfind('.');
    std::string name = ref.text.substr(0, dot);
    const std::string port = dot == std::string::npos ? "" : ref.text.substr(dot + 1);
    const auto raw = std::find_if(scope.doc.nodes.begin(), scope.doc.nodes.end(),
                                  [&](const RawNode& n) { return n.name == name; });
    const std::string path = scope.prefix + name;
    if (raw == scope.doc.nodes.end()) {
      std::vector<std::string> names;
      for (const auto& n : scope.doc.nodes) names.push_back(n.name);
      fail("unknown-node", fmt::format("there is no node '{}'{}", name, did_you_mean(name, names)),
           ref.place);
      return {};
    }
    if (unknown_.count(path) || depth > 64) return {};
    // An output that the graph's user has replaced by an input of his own.
    if (scope.parent)
      for (const auto& [input, target] : scope.doc.inputs)
        if (target.text == ref.text)
          for (const auto& [given, wires] : scope.node->inputs)
            if (given == input && !wires.empty()) return resolve(*scope.parent, wires.front(), depth + 1);
    if (!raw->graph.empty()) {
      const auto it = scopes_.find(path + "/");
      if (it == scopes_.end()) return {};
      std::vector<std::string> names;
      for (const auto& [output, target] : it->second->doc.outputs) {
        if (output == port || (port.empty() && it->second->doc.outputs.size() == 1))
          return resolve(*it->second, target, depth + 1);
        names.push_back(output);
      }
      fail("unknown-port",
           fmt::format("graph '{}' has no output '{}'{}", raw->graph, port, did_you_mean(port, names)),
           ref.place, names.empty() ? "it has no outputs" : fmt::format("it has {}", fmt::join(names, ", ")));
      return {};
    }
    const int node = find(path);
    if (node < 0) return {};
    const NodeType& type = *graph_.nodes[static_cast<std::size_t>(node)].type;
    if (port.empty() && type.outputs.size() == 1) return Wire{node, type.outputs[0].name, ref.place};
    if (type.find_output(port)) return Wire{node, port, ref.place};
    std::vector<std::string> names;
    for (const auto& p : type.outputs) names.push_back(p.name);
    fail("unknown-port",
         fmt::format("{} '{}' has no output '{}'{}", type.name, name, port, did_you_mean(port, names)),
         ref.place, names.empty() ? "it has no outputs" : fmt::format("it has {}", fmt::join(names, ", ")));
    return {};
  }

  void connect(Scope& scope, const RawNode& raw) {
    const std::string path = scope.prefix + raw.name;
    if (!raw.graph.empty()) return check_subgraph_inputs(scope, raw);
    const int index = find(path);
    if (index < 0) {
      for (const auto& [port, refs] : raw.inputs)
        for (const auto& ref : refs) resolve(scope, ref);  // their own mistakes show all the same
      return;
    }
    for (const auto& [port, refs] : raw.inputs) {
      GraphNode& node = graph_.nodes[static_cast<std::size_t>(index)];
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
        fail("too-many-wires", fmt::format("input '{}' takes one wire, not {}", port, refs.size()),
             refs[1].place, {}, path);
        continue;
      }
      for (const auto& ref : refs) attach(scope, index, *p, ref);
    }
    // Inputs of the surrounding graph that end in an input of this node.
    if (scope.parent)
      for (const auto& [input, target] : scope.doc.inputs)
        for (const auto& [given, wires] : scope.node->inputs) {
          const GraphNode& node = graph_.nodes[static_cast<std::size_t>(index)];
          const std::string start = raw.name + ".";
          if (given != input || target.text.rfind(start, 0) != 0) continue;
          const Port* p = node.type->find_input(target.text.substr(start.size()));
          if (p && !node.type->find_output(p->name))
            for (const auto& ref : wires) attach(*scope.parent, index, *p, ref);
        }
  }

  void attach(Scope& scope, int index, const Port& port, const RawReference& ref) {
    const auto wire = resolve(scope, ref);
    broken_inputs_.insert(
        {index, port.name});  // a wire was meant: "missing input" would be a second, wrong message
    if (!wire) return;
    const std::string& type =
        graph_.nodes[static_cast<std::size_t>(wire->node)].type->find_output(wire->port)->types[0];
    GraphNode& node = graph_.nodes[static_cast<std::size_t>(index)];
    if (!port.accepts(type))
      return fail(
          "wrong-type",
          fmt::format("input '{}' takes {}, but {} is {}", port.name, port.type_text(), ref.text, type),
          ref.place, {}, node.path);
    Wire w = *wire;
    w.place = ref.place;
    node.inputs[port.name].push_back(std::move(w));
  }

  void check_subgraph_inputs(Scope& scope, const RawNode& raw) {
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

  void check_wiring_of_ports() {
    for (std::size_t i = 0; i < graph_.nodes.size(); ++i) {
      const GraphNode& node = graph_.nodes[i];
      for (const auto& port : node.type->inputs)
        if (!port.optional && !node.inputs.count(port.name) &&
            !broken_inputs_.count({static_cast<int>(i), port.name}))
          fail("missing-input",
               fmt::format("{} needs the input '{}' ({})", node.type->name, port.name, port.type_text()),
               node.place, {}, node.path);
      for (const auto& p : node.type->parameters)
        if (!p.value && !node.parameters.count(p.name) && !attempted_.count({node.path, p.name}))
          fail("missing-parameter",
               fmt::format("{} needs the parameter '{}' ({})", node.type->name, p.name, p.doc), node.place,
               {}, node.path);
    }
  }

  // Sources before consumers, otherwise in the order written.
  void sort() {
    const std::size_t n = graph_.nodes.size();
    std::vector<int> state(n, 0), order;
    std::vector<int> stack;
    std::function<bool(int)> visit = [&](int i) {
      if (state[static_cast<std::size_t>(i)] == 2) return true;
      if (state[static_cast<std::size_t>(i)] == 1) {
        std::string way;
        for (auto it = std::find(stack.begin(), stack.end(), i); it != stack.end(); ++it)
          way += graph_.nodes[static_cast<std::size_t>(*it)].path + " → ";
        const auto& node = graph_.nodes[static_cast<std::size_t>(i)];
        fail("cycle", "the wires run in a circle: " + way + node.path, node.place);
        return false;
      }
      state[static_cast<std::size_t>(i)] = 1;
      stack.push_back(i);
      for (const auto& [port, wires] : graph_.nodes[static_cast<std::size_t>(i)].inputs)
        for (const auto& w : wires)
          if (!visit(w.node)) return false;
      stack.pop_back();
      state[static_cast<std::size_t>(i)] = 2;
      order.push_back(i);
      return true;
    };
    for (std::size_t i = 0; i < n; ++i)
      if (!visit(static_cast<int>(i))) return;
    std::vector<int> place(n);
    std::vector<GraphNode> sorted;
    for (std::size_t k = 0; k < n; ++k) place[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
    for (const int i : order) {
      sorted.push_back(std::move(graph_.nodes[static_cast<std::size_t>(i)]));
      for (auto& [port, wires] : sorted.back().inputs)
        for (auto& w : wires) w.node = place[static_cast<std::size_t>(w.node)];
    }
    graph_.nodes = std::move(sorted);
    for (auto& o : graph_.outputs) o.wire.node = place[static_cast<std::size_t>(o.wire.node)];
  }

  const Registry& registry_;
  const Overrides& overrides_;
  Diagnostics& found_;
  std::vector<bool> used_;
  Graph graph_;
  std::map<std::string, std::unique_ptr<Scope>> scopes_;
  std::map<std::string, int> index_;  // of graph_.nodes by path
  std::set<std::string> unknown_;     // paths whose type or file is unknown, already reported
  std::set<std::pair<int, std::string>> broken_inputs_;
  std::set<std::pair<std::string, std::string>> attempted_;  // parameters written, rightly or not
};

}  // namespace

Graph load_graph_text(const std::string& text, const fs::path& file, const Registry& registry,
                      const Overrides& overrides, Diagnostics& found) {
  RawDocument doc = read_document(text, file.lexically_normal(), found);
  return Linker(registry, overrides, found).link(std::move(doc));
}

Graph load_graph(const fs::path& file, const Registry& registry, const Overrides& overrides,
                 Diagnostics& found) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  if (!in || fs::is_directory(file) || !(text << in.rdbuf())) {
    found.push_back(
        {Severity::Error, "no-file", "cannot read the graph file '" + file.string() + "'", {}, {}, {}, {}});
    return {};
  }
  return load_graph_text(text.str(), file, registry, overrides, found);
}

}  // namespace terrazzo
