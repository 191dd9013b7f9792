#include "graph/graph.h"

#include "graph/text/element_name.h"
#include "graph/text/nearest.h"

namespace terrazzo {

int Graph::find(const std::string& path) const {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].path == path) return i;
  return -1;
}

std::vector<std::string> Graph::paths() const {
  std::vector<std::string> out;
  for (const auto& n : nodes) out.push_back(n.path);
  return out;
}

Wire Graph::wire_to(const std::string& text) const {
  for (const auto& o : outputs)
    if (o.name == text) return o.wire;
  const auto dot = find_port_dot(text);
  const std::string path = text.substr(0, dot);
  const int node = find(path);
  if (const auto at = bypassed.find(path); at != bypassed.end()) {
    const auto& passed = at->second;
    if (dot == std::string::npos && passed.size() == 1) return passed.begin()->second;
    const auto port = passed.find(dot == std::string::npos ? "" : text.substr(dot + 1));
    if (port != passed.end()) return port->second;
    throw Error("cannot-bypass", "'" + path + "' is bypassed, and passes nothing through to '" + text + "'",
                "remove `bypass` from the node");
  }
  std::vector<std::string> elements;
  for (const auto& o : outputs)
    if (is_named(o.name, text)) elements.push_back(o.name);
  if (node < 0 && elements.empty())
    for (const auto& n : nodes)
      if (is_named(n.path, path)) elements.push_back(n.path);
  for (const auto& [bypassed_path, passed] : bypassed)
    if (node < 0 && is_named(bypassed_path, path)) elements.push_back(bypassed_path);
  if (node < 0 && !elements.empty())
    throw Error("several-values", "'" + text + "' is a list of " + std::to_string(elements.size()),
                "name one element, such as " + elements.front());
  if (node < 0) throw Error("unknown-node", "there is no node '" + path + "'" + did_you_mean(path, paths()));
  const NodeType& type = *nodes[node].type;
  if (dot == std::string::npos) {
    if (type.outputs.size() == 1) return {node, type.outputs[0].name, {}};
    throw Error("unknown-port", type.name + " '" + path + "' has " + std::to_string(type.outputs.size()) +
                                    " outputs: choose one with " + path + ".PORT");
  }
  const std::string port = text.substr(dot + 1);
  if (const Port* former = type.find_output(port) ? nullptr : type.find_former_output(port))
    return {node, former->name, {}};
  if (!type.find_output(port)) {
    std::vector<std::string> names;
    for (const auto& p : type.outputs) names.push_back(p.name);
    throw Error("unknown-port",
                type.name + " '" + path + "' has no output '" + port + "'" + did_you_mean(port, names));
  }
  return {node, port, {}};
}

std::vector<int> Graph::sinks() const {
  std::vector<bool> consumed(nodes.size(), false), wanted(nodes.size(), false);
  for (const auto& n : nodes)
    for (const auto& [port, wires] : n.inputs)
      for (const auto& w : wires) consumed[w.node] = true;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    wanted[i] = nodes[i].type->writes_files || (!consumed[i] && !nodes[i].in_subgraph());
  for (const auto& o : outputs) wanted[o.wire.node] = true;
  std::vector<int> out;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (wanted[i]) out.push_back(i);
  return out;
}

}  // namespace terrazzo
